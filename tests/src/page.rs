//! Pages that are compared.

/// A page without when, by which command and of what it was made: what two pages of the same result may differ in.
///
/// # Panics
/// The page does not say how it was made.
#[must_use]
pub fn without_its_making(page: &str) -> String {
    let (before, rest) = page.split_once("<details class=\"about\">").expect("a page says how it was made");
    before.to_owned() + rest.split_once("</details>").expect("what is begun ends").1
}
