//! The page and its parts, as they are in the source.

/// The one page of the dashboard; its scripts look at the address.
pub(super) const PAGE: &str = include_str!("assets/index.html");

const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// A part of the page by its name: type and content.
pub(super) fn part(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "icon.svg" => ("image/svg+xml", include_str!("assets/icon.svg")),
        "style.css" => (STYLE, include_str!("assets/style.css")),
        "charts.css" => (STYLE, include_str!("assets/charts.css")),
        "app.js" => (SCRIPT, include_str!("assets/app.js")),
        "chart.js" => (SCRIPT, include_str!("assets/chart.js")),
        "curves.js" => (SCRIPT, include_str!("assets/curves.js")),
        "dom.js" => (SCRIPT, include_str!("assets/dom.js")),
        "individual.js" => (SCRIPT, include_str!("assets/individual.js")),
        "overview.js" => (SCRIPT, include_str!("assets/overview.js")),
        "experiment.js" => (SCRIPT, include_str!("assets/experiment.js")),
        "replication.js" => (SCRIPT, include_str!("assets/replication.js")),
        "words.js" => (SCRIPT, include_str!("assets/words.js")),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCRIPTS: [&str; 9] = [
        "app.js",
        "chart.js",
        "curves.js",
        "dom.js",
        "individual.js",
        "overview.js",
        "experiment.js",
        "replication.js",
        "words.js",
    ];

    #[test]
    fn nothing_is_fetched_from_elsewhere() {
        let parts = SCRIPTS.iter().chain(&["style.css", "charts.css", "icon.svg"]);
        for name in parts {
            let (_, text) = part(name).unwrap();
            let text = text.replace("http://www.w3.org/2000/svg", "");
            assert!(!text.contains("http://") && !text.contains("https://"), "{name}");
        }
        assert!(!PAGE.contains("http://") && !PAGE.contains("https://"));
    }

    #[test]
    fn every_part_that_is_named_is_there() {
        for link in PAGE.split(['"', '\'']).filter_map(|word| word.strip_prefix("/assets/")) {
            assert!(part(link).is_some(), "{link}");
        }
        for name in SCRIPTS {
            let (_, text) = part(name).unwrap();
            for line in text.lines().filter(|line| line.starts_with("import ")) {
                let link = line.split('"').nth(1).and_then(|word| word.strip_prefix("./")).unwrap();
                assert!(part(link).is_some(), "{name}: {link}");
            }
        }
    }

    #[test]
    fn no_text_becomes_markup() {
        // Names of machines and reasons of failures come from elsewhere.
        for name in SCRIPTS {
            let (_, text) = part(name).unwrap();
            for word in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("] {
                assert!(!text.contains(word), "{name}: {word}");
            }
        }
    }
}
