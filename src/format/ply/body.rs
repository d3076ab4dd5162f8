//! The numbers of a PLY file's body, one after the other.

use super::super::mesh::{Wrong, shown};
use super::header::Type;

const CUT: &str = "the file is cut short, or its counts are wrong";

/// Gives the numbers in the order of the file.
pub(super) trait Body {
    /// The next number.
    fn number(&mut self, kind: Type) -> Result<f64, Wrong>;
    /// The next number, of an integer type.
    fn whole(&mut self, kind: Type) -> Result<i64, Wrong>;
    /// Where it stands: the byte in binary files, the line in texts.
    fn place(&self) -> usize;
    /// How many bytes have been read.
    fn bytes(&self) -> usize;
}

/// A binary body.
pub(super) struct Binary<'b, const BIG: bool> {
    pub bytes: &'b [u8],
    pub at: usize,
}

impl<const BIG: bool> Binary<'_, BIG> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Wrong> {
        let found = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let mut bytes = *found.ok_or_else(|| ("the file ends here".to_owned(), CUT))?;
        self.at += N;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Body for Binary<'_, BIG> {
    #[inline]
    fn number(&mut self, kind: Type) -> Result<f64, Wrong> {
        match kind {
            Type::F32 => Ok(f64::from(f32::from_le_bytes(self.take()?))),
            Type::F64 => Ok(f64::from_le_bytes(self.take()?)),
            _ => self.whole(kind).map(|n| n as f64),
        }
    }

    #[inline]
    fn whole(&mut self, kind: Type) -> Result<i64, Wrong> {
        Ok(match kind {
            Type::I8 => i8::from_le_bytes(self.take()?).into(),
            Type::U8 => u8::from_le_bytes(self.take()?).into(),
            Type::I16 => i16::from_le_bytes(self.take()?).into(),
            Type::U16 => u16::from_le_bytes(self.take()?).into(),
            Type::I32 => i32::from_le_bytes(self.take()?).into(),
            Type::U32 => u32::from_le_bytes(self.take()?).into(),
            // The header lets no other type be asked for.
            Type::F32 | Type::F64 => return Err(no_number("")),
        })
    }

    fn place(&self) -> usize {
        self.at
    }

    fn bytes(&self) -> usize {
        self.at
    }
}

/// A body of words.
pub(super) struct Ascii<'b> {
    pub bytes: &'b [u8],
    pub at: usize,
    /// Of the last word, from 1.
    pub line: usize,
}

impl Ascii<'_> {
    #[inline]
    fn word(&mut self) -> Result<&str, Wrong> {
        let mut at = self.at;
        while let Some(byte) = self.bytes.get(at)
            && byte.is_ascii_whitespace()
        {
            self.line += usize::from(*byte == b'\n');
            at += 1;
        }
        let start = at;
        while self.bytes.get(at).is_some_and(|byte| !byte.is_ascii_whitespace()) {
            at += 1;
        }
        self.at = at;
        if start == at {
            return Err(("the file ends here".to_owned(), CUT));
        }
        let not_text = |_| ("there are bytes here that are no text".to_owned(), "export it anew as PLY");
        std::str::from_utf8(&self.bytes[start..at]).map_err(not_text)
    }
}

fn no_number(word: &str) -> Wrong {
    (format!("`{}` is not a number of its property's type", shown(word)), "repair it or export the mesh anew")
}

impl Body for Ascii<'_> {
    #[inline]
    fn number(&mut self, kind: Type) -> Result<f64, Wrong> {
        let word = self.word()?;
        let number = match kind {
            Type::F32 => word.parse::<f32>().map(f64::from),
            _ => word.parse::<f64>(),
        };
        number.map_err(|_| no_number(word))
    }

    #[inline]
    fn whole(&mut self, _: Type) -> Result<i64, Wrong> {
        let word = self.word()?;
        word.parse::<i64>().map_err(|_| no_number(word))
    }

    fn place(&self) -> usize {
        self.line
    }

    fn bytes(&self) -> usize {
        self.at
    }
}
