//! Numbers of a MAT-file: stored in the smallest type that holds them, whatever type they have in MATLAB.

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    I64,
    U64,
}

impl Stored {
    /// The type of this number in the file.
    pub(crate) fn of(kind: u32) -> Option<Self> {
        Some(match kind {
            1 => Stored::I8,
            2 => Stored::U8,
            3 => Stored::I16,
            4 => Stored::U16,
            5 => Stored::I32,
            6 => Stored::U32,
            7 => Stored::F32,
            9 => Stored::F64,
            12 => Stored::I64,
            13 => Stored::U64,
            _ => return None,
        })
    }

    /// How many bytes a number takes.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Stored::I8 | Stored::U8 => 1,
            Stored::I16 | Stored::U16 => 2,
            Stored::I32 | Stored::U32 | Stored::F32 => 4,
            Stored::F64 | Stored::I64 | Stored::U64 => 8,
        }
    }
}

/// The type of the numbers in MATLAB, as far as it matters here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// `single`: stored values are rounded to single precision.
    Single,
    /// Any other type.
    Plain,
}

impl Class {
    pub(crate) fn of(class: u32) -> Self {
        if class == 7 { Class::Single } else { Class::Plain }
    }
}

/// The numbers of a vector, as they are stored.
#[derive(Debug)]
pub(crate) struct Numbers {
    pub(crate) class: Class,
    pub(crate) stored: Stored,
    pub(crate) bytes: Vec<u8>,
}

impl Numbers {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len() / self.stored.bytes()
    }

    /// All of them.
    #[expect(clippy::cast_possible_truncation, reason = "a single is what MATLAB holds")]
    pub(crate) fn values(&self) -> Vec<f64> {
        fn each<const N: usize>(bytes: &[u8], value: impl Fn([u8; N]) -> f64) -> Vec<f64> {
            bytes.as_chunks::<N>().0.iter().map(|bytes| value(*bytes)).collect()
        }
        let bytes = &self.bytes;
        let values = match self.stored {
            Stored::I8 => each(bytes, |bytes| f64::from(i8::from_le_bytes(bytes))),
            Stored::U8 => each(bytes, |bytes| f64::from(u8::from_le_bytes(bytes))),
            Stored::I16 => each(bytes, |bytes| f64::from(i16::from_le_bytes(bytes))),
            Stored::U16 => each(bytes, |bytes| f64::from(u16::from_le_bytes(bytes))),
            Stored::I32 => each(bytes, |bytes| f64::from(i32::from_le_bytes(bytes))),
            Stored::U32 => each(bytes, |bytes| f64::from(u32::from_le_bytes(bytes))),
            Stored::F32 => each(bytes, |bytes| f64::from(f32::from_le_bytes(bytes))),
            Stored::F64 => each(bytes, f64::from_le_bytes),
            Stored::I64 => each(bytes, |bytes| i64::from_le_bytes(bytes) as f64),
            Stored::U64 => each(bytes, |bytes| u64::from_le_bytes(bytes) as f64),
        };
        match self.class {
            Class::Single => values.into_iter().map(|value| f64::from(value as f32)).collect(),
            Class::Plain => values,
        }
    }
}
