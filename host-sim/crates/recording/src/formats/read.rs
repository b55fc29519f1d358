//! Reading: a file or any other source, in the format that its first bytes show, as a whole or in parts.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::chunks::{PART_ROWS, Parts};
use super::format::Format;
#[cfg(any(feature = "mat", feature = "mdf4", feature = "parquet", feature = "xlsx"))]
use super::source::held;
use super::source::{open, recognised};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::Place;
use crate::formats::text::csv::Opened;
use crate::formats::text::lines::Input;
use crate::recording::Recording;

/// Reads a recording; `map` says which columns hold which signals where their headers do not.
pub fn read(path: &Path, map: &ChannelMap) -> Result<Recording, RecordingError> {
    read_through(path, map, |file| file)
}

/// As [`read`], through a reader that wraps the file, such as one that counts bytes.
pub fn read_through<R: Read>(
    path: &Path,
    map: &ChannelMap,
    around: impl FnOnce(File) -> R,
) -> Result<Recording, RecordingError> {
    let (name, file) = open(path)?;
    read_from(&name, around(file), map)
}

/// Reads a recording from anywhere, in the format that its first bytes show; `name` stands for the file in messages.
///
/// ```
/// use recording::{ChannelMap, Signal, read_from};
///
/// let text = "time [ms];command [V];Kolbenweg [mm]\n0;0;125,0\n1;2,5;125,5\n2;2,5;126,0\n";
/// let map = ChannelMap::from_arguments(["position=Kolbenweg [mm]"])?;
/// let recording = read_from("press.csv", text.as_bytes(), &map)?;
/// assert_eq!(recording.rows(), 3);
/// let position_m = recording.signal(Signal::Position).expect("it is mapped"); // SI inside
/// assert!((position_m[1] - 0.1255).abs() < 1e-9);
///
/// let error = read_from("press.csv", "time [s],command [furlong]\n0,1\n".as_bytes(), &map);
/// assert!(error.is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_from(name: &str, input: impl Read, map: &ChannelMap) -> Result<Recording, RecordingError> {
    whole(name, Box::new(input), map)
}

fn whole(name: &str, input: Input<'_>, map: &ChannelMap) -> Result<Recording, RecordingError> {
    opened(name, input, map)?.whole().map_err(|error| of_its_name(name, error))
}

/// Reads a recording in parts of about [`PART_ROWS`] rows, through a reader that wraps the file.
///
/// # Errors
/// Those of [`read`] that occur up to the header of a text; a file that is not text is read completely here.
pub fn in_parts<'a, R: Read + 'a>(
    path: &Path,
    map: &ChannelMap,
    around: impl FnOnce(File) -> R,
) -> Result<Parts<'a>, RecordingError> {
    let (name, file) = open(path)?;
    parts_of(&name, Box::new(around(file)), map, PART_ROWS)
}

/// The same from any source, in parts of about `usual_rows` rows.
pub fn parts_of<'a>(
    name: &str,
    input: Box<dyn Read + 'a>,
    map: &ChannelMap,
    usual_rows: usize,
) -> Result<Parts<'a>, RecordingError> {
    Ok(Parts::of(opened(name, input, map)?, usual_rows))
}

/// Opens a recording in the format that its first bytes show: of a text only the header is read, any other format is read as a whole.
fn opened<'a>(name: &str, input: Input<'a>, map: &ChannelMap) -> Result<Opened<'a>, RecordingError> {
    let (format, all) = recognised(name, input)?;
    match format {
        Format::Text => Opened::text(name, all, map).map_err(|error| of_its_name(name, error)),
        #[cfg(feature = "gzip")]
        Format::Gzip => {
            let inner = super::gzip::unpacked(name, all)?;
            opened(name, inner, map)
        }
        #[cfg(feature = "xlsx")]
        Format::Xlsx => super::xlsx::open(name, held(name, all)?, map),
        #[cfg(feature = "mat")]
        Format::Mat => super::mat::read(name, &held(name, all)?, map).map(Opened::Whole),
        #[cfg(feature = "mdf4")]
        Format::Mdf4 => super::mdf4::read(name, &held(name, all)?, map).map(Opened::Whole),
        #[cfg(feature = "parquet")]
        Format::Parquet => super::parquet::read(name, held(name, all)?, map).map(Opened::Whole),
        #[allow(unreachable_patterns, reason = "reached where the program was built without a feature")]
        format => Err(RecordingError::FeatureAbsent { place: Place::file(name), format }),
    }
}

/// Where the file is not text and its name has the extension of another format, the error says that the file is not of that format.
pub(crate) fn of_its_name(name: &str, error: RecordingError) -> RecordingError {
    let no_text = matches!(
        error,
        RecordingError::NotUtf8 { .. } | RecordingError::ControlCharacter { .. } | RecordingError::LineTooLong { .. }
    );
    match Format::of_extension(Path::new(name)) {
        Some(format) if no_text && format != Format::Text => {
            RecordingError::NotOfFormat { place: Place::file(name), format }
        }
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_whatever_its_name_says() {
        let text = "time [s],spool\n0,0\n1,1\n";
        assert_eq!(read_from("run.mat", text.as_bytes(), &ChannelMap::default()).map(|read| read.rows()).ok(), Some(2));
    }

    #[test]
    fn a_format_that_is_left_out_names_its_feature() {
        let told = RecordingError::FeatureAbsent { place: Place::file("run.mf4"), format: Format::Mdf4 }.to_string();
        let expected = "run.mf4: an MDF file, which this build of the program leaves out; expected the program built with the \
                        feature `mdf4`, or CSV";
        assert_eq!(told, expected);
        #[cfg(not(feature = "mdf4"))]
        assert_eq!(
            read_from("run.mf4", b"MDF     4.10".as_slice(), &ChannelMap::default()).unwrap_err().to_string(),
            expected
        );
    }
}
