//! Sequential readers of the numbers in a PLY body: one for binary files, one for text.

use super::header::PlyNumberType;
use crate::format::line_error::{MessageAndRemedy, escaped_excerpt};

const TRUNCATED_REMEDY: &str = "the file is cut short, or its counts are wrong";

/// Sequential reader of the numbers in a PLY body.
pub(super) trait PlyNumberReader {
    /// Returns the next number of the body, which has the type `kind`.
    fn read_number(&mut self, kind: PlyNumberType) -> Result<f64, MessageAndRemedy>;
    /// Returns the next number of the body, which has the integer type `kind`.
    fn read_integer(&mut self, kind: PlyNumberType) -> Result<i64, MessageAndRemedy>;
    /// Returns the reader's position for error messages: a byte offset in binary files, a line
    /// number in text files.
    fn error_position(&self) -> usize;
    /// Returns the offset of the next byte from the start of the file.
    fn bytes_read(&self) -> usize;
    /// Returns an upper bound of the count of numbers of type `kind` in the rest of the file.
    fn max_remaining_values(&self, kind: PlyNumberType) -> u64;
}

/// Reader of a binary PLY body, which is big-endian if `BIG` is true.
pub(super) struct PlyBinaryReader<'b, const BIG: bool> {
    pub bytes: &'b [u8],
    /// Offset of the next byte from the start of the file.
    pub offset: usize,
}

impl<const BIG: bool> PlyBinaryReader<'_, BIG> {
    #[inline]
    fn take_little_endian_bytes<const N: usize>(&mut self) -> Result<[u8; N], MessageAndRemedy> {
        let next = self.bytes.get(self.offset..).and_then(|rest| rest.first_chunk::<N>());
        let mut bytes = *next.ok_or_else(|| ("the file ends here".to_owned(), TRUNCATED_REMEDY))?;
        self.offset += N;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> PlyNumberReader for PlyBinaryReader<'_, BIG> {
    #[inline]
    fn read_number(&mut self, kind: PlyNumberType) -> Result<f64, MessageAndRemedy> {
        match kind {
            PlyNumberType::F32 => Ok(f64::from(f32::from_le_bytes(self.take_little_endian_bytes()?))),
            PlyNumberType::F64 => Ok(f64::from_le_bytes(self.take_little_endian_bytes()?)),
            PlyNumberType::I8
            | PlyNumberType::U8
            | PlyNumberType::I16
            | PlyNumberType::U16
            | PlyNumberType::I32
            | PlyNumberType::U32 => self.read_integer(kind).map(|n| n as f64),
        }
    }

    #[inline]
    fn read_integer(&mut self, kind: PlyNumberType) -> Result<i64, MessageAndRemedy> {
        Ok(match kind {
            PlyNumberType::I8 => i8::from_le_bytes(self.take_little_endian_bytes()?).into(),
            PlyNumberType::U8 => u8::from_le_bytes(self.take_little_endian_bytes()?).into(),
            PlyNumberType::I16 => i16::from_le_bytes(self.take_little_endian_bytes()?).into(),
            PlyNumberType::U16 => u16::from_le_bytes(self.take_little_endian_bytes()?).into(),
            PlyNumberType::I32 => i32::from_le_bytes(self.take_little_endian_bytes()?).into(),
            PlyNumberType::U32 => u32::from_le_bytes(self.take_little_endian_bytes()?).into(),
            // The header check accepts lists and indices of integer types only.
            PlyNumberType::F32 | PlyNumberType::F64 => return Err(invalid_number_error("")),
        })
    }

    fn error_position(&self) -> usize {
        self.offset
    }

    fn bytes_read(&self) -> usize {
        self.offset
    }

    #[inline]
    fn max_remaining_values(&self, kind: PlyNumberType) -> u64 {
        ((self.bytes.len() - self.offset) / kind.byte_size()) as u64
    }
}

/// Reader of a text PLY body, whose numbers are separated by white space.
pub(super) struct PlyTextReader<'b> {
    pub bytes: &'b [u8],
    /// Offset of the next byte from the start of the file.
    pub offset: usize,
    /// Line number, from 1, of the word that was read last.
    pub line: usize,
}

impl PlyTextReader<'_> {
    #[inline]
    fn next_word(&mut self) -> Result<&str, MessageAndRemedy> {
        let mut end = self.offset;
        while let Some(byte) = self.bytes.get(end)
            && byte.is_ascii_whitespace()
        {
            self.line += usize::from(*byte == b'\n');
            end += 1;
        }
        let start = end;
        while self.bytes.get(end).is_some_and(|byte| !byte.is_ascii_whitespace()) {
            end += 1;
        }
        self.offset = end;
        if start == end {
            return Err(("the file ends here".to_owned(), TRUNCATED_REMEDY));
        }
        let not_text = |_| ("there are bytes here that are no text".to_owned(), "export it anew as PLY");
        std::str::from_utf8(&self.bytes[start..end]).map_err(not_text)
    }
}

fn invalid_number_error(word: &str) -> MessageAndRemedy {
    let message = format!("`{}` is not a number of its property's type", escaped_excerpt(word));
    (message, "repair it or export the mesh anew")
}

impl PlyNumberReader for PlyTextReader<'_> {
    #[inline]
    fn read_number(&mut self, kind: PlyNumberType) -> Result<f64, MessageAndRemedy> {
        let word = self.next_word()?;
        let number = match kind {
            PlyNumberType::F32 => word.parse::<f32>().map(f64::from),
            PlyNumberType::I8
            | PlyNumberType::U8
            | PlyNumberType::I16
            | PlyNumberType::U16
            | PlyNumberType::I32
            | PlyNumberType::U32
            | PlyNumberType::F64 => word.parse::<f64>(),
        };
        number.map_err(|_| invalid_number_error(word))
    }

    #[inline]
    fn read_integer(&mut self, _: PlyNumberType) -> Result<i64, MessageAndRemedy> {
        let word = self.next_word()?;
        word.parse::<i64>().map_err(|_| invalid_number_error(word))
    }

    fn error_position(&self) -> usize {
        self.line
    }

    fn bytes_read(&self) -> usize {
        self.offset
    }

    #[inline]
    fn max_remaining_values(&self, _: PlyNumberType) -> u64 {
        // A number takes at least a digit and a separator.
        ((self.bytes.len() - self.offset) / 2) as u64
    }
}
