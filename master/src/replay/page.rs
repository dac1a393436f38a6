//! A recording as a page that plays it in any browser, without a server or a network.

use super::Recording;

const PAGE: &str = include_str!("replay.html");
/// Where the page has its data.
const PLACE: &str = "/*recording*/null";

/// The page of some trials. It has everything in it: a single file to open, keep and pass on.
///
/// # Errors
/// When a recording cannot be written as JSON, as when a number in it is not finite.
pub fn page(recordings: &[Recording]) -> Result<String, serde_json::Error> {
    // A name could end the script.
    let data = serde_json::to_string(recordings)?.replace('<', "\\u003c");
    Ok(PAGE.replacen(PLACE, &data, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn the_page_has_its_data_and_fetches_nothing() {
        assert_eq!(PAGE.matches(PLACE).count(), 1);
        let mut recording = recording(&["reach.steps=3"], 0);
        recording.individual = "</script>".to_owned();
        let page = page(&[recording]).unwrap();
        assert!(!page.contains(PLACE) && page.contains("\\u003c/script>"));
        assert_eq!(page.matches("</script>").count(), 1);
        for word in ["http://", "https://", "import ", "fetch(", "src="] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
