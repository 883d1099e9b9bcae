//! `terrane study` as a process.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};

#[test]
fn every_cost_is_pictured_at_every_face_count_with_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let output = terrane(&["study", "--out", "a/b", "--json"], folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = summary["table"].as_array().unwrap();
    assert_eq!(rows.len(), 18);
    for row in rows {
        let [asked, faces] = ["asked", "faces"].map(|key| row[key].as_u64().unwrap());
        assert!(faces <= asked && faces + 2 > asked, "{row}");
        assert_eq!(row["uncovered"], 0);
        let [max, rms] = ["max", "rms"].map(|key| row[key].as_f64().unwrap());
        assert!(0.0 < rms && rms < max, "{row}");
    }
    // What is certified has the smallest largest error: at each face count, of all costs.
    let largest = |cost: usize, column: usize| rows[6 * cost + column]["max"].as_f64().unwrap();
    assert!((0..6).all(|column| largest(0, column) < largest(1, column).min(largest(2, column))));
    let png = std::fs::read(folder.path().join("a/b/meshes.png")).unwrap();
    assert!(png.len() < 500_000, "{} bytes", png.len());
    let svg = std::fs::read_to_string(folder.path().join("a/b/errors.svg")).unwrap();
    assert_eq!((svg.matches("<polyline").count(), svg.matches("NaN").count()), (6, 0));
    // A patch is exact when all of it is there, and nearer the more there is.
    let arrival = summary["arrival"].as_array().unwrap();
    let errors: Vec<f64> = arrival.iter().map(|moment| moment["largest_error_m"].as_f64().unwrap()).collect();
    assert!(errors.len() == 3 && errors.is_sorted_by(|a, b| a > b) && errors[2] < 0.01, "{errors:?}");
    assert!(arrival[0]["bytes"].as_u64() < Some(arrival[2]["bytes"].as_u64().unwrap() / 4), "{arrival:?}");
    assert!(folder.path().join("a/b/arrival.png").metadata().unwrap().len() > 10_000);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let output = terrane(&["study", "--out", "file/inside"], folder.path());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("file/inside"), "{}", text(&output.stderr));
}
