//! Texts that a person has looked at.

use std::path::PathBuf;

/// Compares a text with a file of testdata/expected; `LACUNA_BLESS=1` writes the file instead.
pub(crate) fn expect_file(name: &str, text: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/expected").join(name);
    if std::env::var_os("LACUNA_BLESS").is_some() {
        std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        return;
    }
    let expected = std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("{}: {e}; LACUNA_BLESS=1 writes it", path.display()));
    assert_eq!(text, expected, "{name} differs; LACUNA_BLESS=1 takes the new text");
}
