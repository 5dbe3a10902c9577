//! The short run, as a user starts it: every method measures on every scene, and the figures make sense.

use std::path::Path;
use std::process::Command;

fn run(out: &Path) -> serde_json::Value {
    let run = Command::new(env!("CARGO_BIN_EXE_accuracy"))
        .args(["--quick", "--out"])
        .arg(out)
        .output()
        .expect("the bench starts");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let text = std::fs::read_to_string(out.join("accuracy.json")).expect("figures");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn the_short_run_measures_every_method_on_every_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = run(folder.path());
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), 9);
    let mean = |kind: &str, method: &str| -> f64 {
        let row = rows.iter().find(|r| r["kind"] == kind && r["method"] == method);
        let outcome = &row.expect("a row")["outcome"]["Ok"];
        let figures = &outcome["figures"];
        assert_eq!(figures["missed"], 0.0, "{kind}, {method}: every true vertex has new surface");
        assert!(outcome["cost"]["peak_mib"].as_f64().is_some_and(|m| m > 1.0));
        figures["error"]["mean_m"].as_f64().expect("a number")
    };
    for kind in ["smooth", "outliers 5 %", "hollow"] {
        for method in ["field", "layered", "aggregate"] {
            let mean_m = mean(kind, method);
            assert!(mean_m > 0.0 && mean_m < 1.0, "{kind}, {method}: {mean_m} m on a relief of 2 m");
        }
    }
    // A robust surface forgives outliers of the rim; one that takes each rim vertex at its word does not.
    assert!(mean("outliers 5 %", "field") < mean("outliers 5 %", "aggregate"));
    for picture in ["smooth_1_section.svg", "smooth_1_map.svg", "smooth_depth.svg", "accuracy.md"] {
        assert!(folder.path().join(picture).is_file(), "{picture}");
    }
}
