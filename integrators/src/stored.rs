//! Values as bytes, for files that keep the state of a render: numbers with the lowest byte first, floats by their
//! bits, lists after their lengths. What is read has the bits of what was written.

use std::io::{self, ErrorKind, Read, Write};

use glam::{Vec2, Vec3};

mod vertices;

/// Something that can be written to a file and read again.
pub trait Stored: Sized {
    /// Writes it.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn store(&self, to: &mut dyn Write) -> io::Result<()>;

    /// Reads what [`Stored::store`] has written.
    ///
    /// # Errors
    /// If the file cannot be read, ends early, or holds something else.
    fn load(from: &mut dyn Read) -> io::Result<Self>;
}

/// The error of a file that holds something else than what is read.
pub fn malformed(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what.to_owned())
}

macro_rules! numbers {
    ($($number:ty),+) => {$(
        impl Stored for $number {
            fn store(&self, to: &mut dyn Write) -> io::Result<()> {
                to.write_all(&self.to_le_bytes())
            }

            fn load(from: &mut dyn Read) -> io::Result<Self> {
                let mut bytes = [0; size_of::<$number>()];
                from.read_exact(&mut bytes)?;
                Ok(<$number>::from_le_bytes(bytes))
            }
        }
    )+};
}

numbers!(u8, u32, u64, i32, i128, f32, f64);

/// Says of a type which other one it is stored as, and how one becomes the other.
macro_rules! stored_as {
    ($type:ty, $other:ty, $there:expr, $back:expr) => {
        impl Stored for $type {
            fn store(&self, to: &mut dyn Write) -> io::Result<()> {
                let there: fn(&$type) -> $other = $there;
                there(self).store(to)
            }

            fn load(from: &mut dyn Read) -> io::Result<Self> {
                let back: fn($other) -> io::Result<$type> = $back;
                back(<$other>::load(from)?)
            }
        }
    };
}

stored_as!(usize, u64, |n| *n as u64, |n| {
    usize::try_from(n).map_err(|_| malformed("a number is larger than this machine's addresses"))
});
stored_as!(bool, u8, |b| u8::from(*b), |n| match n {
    0 => Ok(false),
    1 => Ok(true),
    _ => Err(malformed("neither true nor false")),
});
stored_as!(Vec2, [f32; 2], |v| v.to_array(), |v| Ok(v.into()));
stored_as!(Vec3, [f32; 3], |v| v.to_array(), |v| Ok(v.into()));
stored_as!(String, Vec<u8>, |s| s.as_bytes().to_vec(), |bytes| {
    String::from_utf8(bytes).map_err(|_| malformed("a text is not UTF-8"))
});

impl<T: Stored + Copy + Default, const N: usize> Stored for [T; N] {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.iter().try_for_each(|value| value.store(to))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = T::load(from)?;
        }
        Ok(values)
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.len().store(to)?;
        self.iter().try_for_each(|value| value.store(to))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        // The memory is that of what is there, whatever the file claims.
        let length = usize::load(from)?;
        (0..length).map(|_| T::load(from)).collect()
    }
}

impl<T: Stored> Stored for Option<T> {
    fn store(&self, to: &mut dyn Write) -> io::Result<()> {
        self.is_some().store(to)?;
        self.iter().try_for_each(|value| value.store(to))
    }

    fn load(from: &mut dyn Read) -> io::Result<Self> {
        bool::load(from)?.then(|| T::load(from)).transpose()
    }
}

macro_rules! tuples {
    ($(($($name:ident)+)),+) => {$(
        impl<$($name: Stored),+> Stored for ($($name,)+) {
            #[allow(non_snake_case)]
            fn store(&self, to: &mut dyn Write) -> io::Result<()> {
                let ($($name,)+) = self;
                $($name.store(to)?;)+
                Ok(())
            }

            fn load(from: &mut dyn Read) -> io::Result<Self> {
                Ok(($($name::load(from)?,)+))
            }
        }
    )+};
}

tuples!((A B), (A B C), (A B C D));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_what_was_written() {
        let mut file = Vec::new();
        let value = (
            vec![Some(f32::from_bits(0x7fc0_1234)), None, Some(-0.0)],
            (true, "a light".to_owned(), [i128::MIN, 7]),
            (Vec3::new(1.0, 2.0, 3.0), 5usize),
        );
        type Value = (Vec<Option<f32>>, (bool, String, [i128; 2]), (Vec3, usize));
        value.store(&mut file).unwrap();
        let read = Value::load(&mut &file[..]).unwrap();
        let bits = |v: &Value| v.0.iter().map(|x| x.map(f32::to_bits)).collect::<Vec<_>>();
        assert_eq!((bits(&read), &read.1, read.2), (bits(&value), &value.1, value.2));
        // Every beginning of it ends early.
        for length in 0..file.len() {
            let error = Value::load(&mut &file[..length]).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::UnexpectedEof, "{length}");
        }
    }

    #[test]
    fn claims_of_a_file_take_no_memory() {
        let mut file = Vec::new();
        u64::MAX.store(&mut file).unwrap();
        let error = Vec::<u64>::load(&mut &file[..]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::UnexpectedEof);
        assert_eq!(bool::load(&mut &[2u8][..]).unwrap_err().kind(), ErrorKind::InvalidData);
    }
}
