//! Writing a MAT-file of version 5, without packing: one column vector of doubles for each column.

use std::io;

use crate::formats::sheet::Sheet;
use crate::unit_in_name::variable;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const DOUBLE_CLASS: u32 = 6;

/// The bytes of a file; NaN stands for a missing value.
pub(crate) fn write(sheet: &Sheet<'_>) -> io::Result<Vec<u8>> {
    let mut file = b"MATLAB 5.0 MAT-file, written by host-sim".to_vec();
    file.resize(116, b' ');
    // No subsystem; version 1; little-endian.
    file.extend([0; 8]);
    file.extend(0x0100_u16.to_le_bytes());
    file.extend(b"IM");
    let mut names = Vec::new();
    for column in &sheet.columns {
        let name = variable(&column.header, column.unit, &names);
        let values: Vec<u8> = column.values().flat_map(|value| value.unwrap_or(f64::NAN).to_le_bytes()).collect();
        let rows = length(values.len() / 8)?;
        let parts = [
            element(UINT32, &[DOUBLE_CLASS.to_le_bytes(), [0; 4]].concat())?,
            element(INT32, &[rows.to_le_bytes(), 1_u32.to_le_bytes()].concat())?,
            element(INT8, name.as_bytes())?,
            element(DOUBLE, &values)?,
        ];
        file.extend(element(MATRIX, &parts.concat())?);
        names.push(name);
    }
    Ok(file)
}

/// Type, length, bytes, and zeros up to the next multiple of eight.
fn element(kind: u32, content: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = [kind.to_le_bytes(), length(content.len())?.to_le_bytes()].concat();
    bytes.extend_from_slice(content);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(bytes)
}

/// A length as the format writes it.
fn length(count: usize) -> io::Result<u32> {
    let most = i32::MAX.cast_unsigned();
    let fits = u32::try_from(count).ok().filter(|count| *count <= most);
    fits.ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::FileTooLarge,
            "a variable of more than 2 GiB, which MATLAB's version 5 cannot hold",
        )
    })
}
