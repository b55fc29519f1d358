//! The folder of the resources, which FMI 2.0 gives as a URI.

use std::path::PathBuf;

use percent_encoding::percent_decode_str;

use crate::Refusal;

/// The folder at `file:///…`, `file:/…` or `file://localhost/…`.
pub(crate) fn folder(location: &str) -> Result<PathBuf, Refusal> {
    path(location).map(PathBuf::from).ok_or_else(|| Refusal::Location { found: location.to_owned() })
}

fn path(location: &str) -> Option<String> {
    let (scheme, rest) = location.split_once(':')?;
    let local = match rest.strip_prefix("//") {
        Some(rest) => {
            let (host, _) = rest.split_once('/')?;
            let here = host.is_empty() || host.eq_ignore_ascii_case("localhost");
            here.then(|| &rest[host.len()..])?
        }
        None => rest,
    };
    if !scheme.eq_ignore_ascii_case("file") || !local.starts_with('/') {
        return None;
    }
    let decoded = percent_decode_str(local).decode_utf8().ok()?;
    Some(without_slash(&decoded, cfg!(windows)).to_owned())
}

/// Windows has no slash before the letter of a drive.
fn without_slash(path: &str, windows: bool) -> &str {
    match path.as_bytes() {
        [b'/', letter, b':', ..] if windows && letter.is_ascii_alphabetic() => &path[1..],
        _ => path,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_uri_of_this_computer_names_its_folder() {
        for location in ["file:///a%20b/%C3%BC", "file:/a%20b/%C3%BC", "FILE://localhost/a b/ü"] {
            assert_eq!(folder(location).unwrap(), Path::new("/a b/ü"), "{location}");
        }
        assert_eq!(without_slash("/C:/fmu/resources", true), "C:/fmu/resources");
        assert_eq!(without_slash("/C:/fmu/resources", false), "/C:/fmu/resources");
    }

    #[test]
    fn anything_else_is_refused_with_what_was_found() {
        for location in ["/a/b", "C:\\a", "http://localhost/a", "file://server/a", "file:a/b", "file:///%ff", "file://"]
        {
            let refused = folder(location).unwrap_err().to_string();
            assert!(refused.starts_with(&format!("the resources at {location:?}; expected")), "{refused}");
        }
    }
}
