//! Reads Mitsuba's format `.vol`, which holds values on a regular grid.

/// Values on a regular grid of cells, such as the density of a medium.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct VolumeGrid {
    /// Number of cells along x, y and z.
    pub size: [u32; 3],
    /// Number of channels: 1 or 3.
    pub channel_count: usize,
    /// Lower and upper corner of the grid's box, as stated in the file.
    pub bounds: [[f32; 3]; 2],
    /// Values of all cells, finite and at least 0; x varies fastest. The channels of a cell are
    /// adjacent.
    pub values: Vec<f32>,
}

/// Length of the header of a `.vol` file \[bytes].
const HEADER_BYTES: usize = 48;

/// Decodes a `.vol` file with 32-bit floating-point values.
///
/// # Errors
/// A text, if the file is damaged, or if its version, encoding or number of channels is not
/// supported. Also if a value is negative or not finite.
pub(super) fn decode(file: &[u8]) -> Result<VolumeGrid, String> {
    let Some((header, data)) = file.split_at_checked(HEADER_BYTES) else {
        return Err("the file is too short for the header of a volume".to_owned());
    };
    if &header[..3] != b"VOL" || header[3] != 3 {
        return Err("the file is no `.vol` volume of version 3".to_owned());
    }
    let word = |i: usize| [0, 1, 2, 3].map(|byte| header[4 * i + byte]);
    let integer = |i: usize| u32::from_le_bytes(word(i));
    if integer(1) != 1 {
        return Err("the values of the volume are not 32-bit floating-point numbers".to_owned());
    }
    let (size, channels) = ([integer(2), integer(3), integer(4)], integer(5) as usize);
    if channels != 1 && channels != 3 {
        return Err(format!("volumes with {channels} channels are not read"));
    }
    let count = size.iter().try_fold(channels as u64, |product, side| product.checked_mul(u64::from(*side)));
    if count.is_none_or(|count| count == 0 || count.saturating_mul(4) != data.len() as u64) {
        let [x, y, z] = size;
        return Err(format!("the file holds {} bytes of values for {x} × {y} × {z} cells", data.len()));
    }
    let values: Vec<f32> = data.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    if let Some(value) = values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
        return Err(format!("a value of the volume is {value}"));
    }
    let corner = |first: usize| [0, 1, 2].map(|axis| f32::from_le_bytes(word(first + axis)));
    Ok(VolumeGrid { size, channel_count: channels, bounds: [corner(6), corner(9)], values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_and_values_are_decoded() {
        let mut file = b"VOL\x03".to_vec();
        [1_u32, 2, 1, 1, 1].iter().for_each(|n| file.extend(n.to_le_bytes()));
        [0.0_f32, 0.0, 0.0, 1.0, 1.0, 2.0, 0.5, 3.0].iter().for_each(|x| file.extend(x.to_le_bytes()));
        let grid = decode(&file).unwrap();
        assert_eq!((grid.size, grid.channel_count), ([2, 1, 1], 1));
        assert_eq!((grid.bounds[1], &grid.values[..]), ([1.0, 1.0, 2.0], &[0.5, 3.0][..]));
        assert!((0..file.len()).all(|length| decode(&file[..length]).is_err()));
        file[52..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(decode(&file).is_err());
    }
}
