//! Constraints between quantities: rows that violate one are left out, counted and reported; the others are unchanged.

use crate::common::{at, quiet, read, statuses, study, text, values};
use sweep::{Shard, run, run_in_memory, traces};

const VARY: &str = "bore_m = { from = 0.016, to = 0.063 }\nrod_m = { from = 0.004, to = 0.04 }\ndead_volume_m3 = { from = 0.0, to = 2e-5 }";
const HEAD: &str = "design = \"sobol\"\nsamples = 3000\nseed = 2\nfit = false";

fn constrained(list: &str) -> String {
    format!("constraints = {list}\n{VARY}")
}

#[test]
fn rows_that_break_a_constraint_are_left_out_and_counted_and_the_others_stay() {
    let list = "[\"rod_m <= 0.5 * bore_m\", \"dead_volume_m3 < 0.2 * stroke_volume_m3\"]";
    let (free, bound) = (study(HEAD, VARY), study(HEAD, &constrained(list)));
    let [free_folder, folder] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    run(&free, &at(&free_folder), Shard::WHOLE, &quiet).unwrap();
    let report = run(&bound, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let all = |folder: &std::path::Path| {
        let tables: Vec<_> =
            (0..bound.parts).map(|part| read(&folder.join("rows").join(bound.part_name(part)))).collect();
        arrow::compute::concat_batches(&tables[0].schema(), &tables).unwrap()
    };
    let (free, rows) = (all(free_folder.path()), all(folder.path()));
    let [bore, rod, dead] = ["bore_m", "rod_m", "dead_volume_m3"].map(|name| values(&rows, name));
    let (peaks, expected) = (values(&rows, "pressure_peak_pa"), values(&free, "pressure_peak_pa"));
    let (found, before) = (statuses(&rows), statuses(&free));
    let mut counts = [0; 2];
    for i in 0..rows.num_rows() {
        let stroke_volume = std::f64::consts::PI / 4.0 * (bore[i] * bore[i] - rod[i] * rod[i]) * 0.05;
        if rod[i] >= bore[i] {
            // No possible cylinder.
            assert_eq!(found[i], before[i]);
        } else if rod[i] > 0.5 * bore[i] {
            assert_eq!(found[i], "left_out: rod_m <= 0.5 * bore_m");
            assert!(peaks[i].is_nan());
            counts[0] += 1;
        } else if dead[i] >= 0.2 * stroke_volume {
            assert_eq!(found[i], "left_out: dead_volume_m3 < 0.2 * stroke_volume_m3");
            counts[1] += 1;
        } else {
            assert_eq!((peaks[i].to_bits(), &found[i]), (expected[i].to_bits(), &before[i]));
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
    assert_eq!(report.statuses["left_out: rod_m <= 0.5 * bore_m"], counts[0]);
    assert_eq!(report.statuses["left_out: dead_volume_m3 < 0.2 * stroke_volume_m3"], counts[1]);
    // A row left out has no trace.
    let row = found.iter().position(|status| status.starts_with("left_out: rod")).unwrap();
    let report = traces::write(&bound, &at(&folder), &row.to_string().parse().unwrap(), 100.0).unwrap();
    assert_eq!(report.without, [(row as u64, "left_out: rod_m <= 0.5 * bore_m".to_owned())]);
}

#[test]
fn a_constraint_can_refer_to_what_is_derived_for_a_row() {
    let vary = "constraints = [\"0.02 < bore_m < 0.05\"]\nvolume_to_area_m = { from = 0.003, to = 0.012, count = 200 }";
    let study = study("design = \"factorial\"\nfit = false", vary);
    let rows = &run_in_memory(&study).unwrap()[0];
    let (ratios, bores, found) = (values(rows, "volume_to_area_m"), values(rows, "bore_m"), statuses(rows));
    let ok: Vec<usize> = (0..200).filter(|i| !found[*i].starts_with("left_out")).collect();
    assert!(ok.len() > 20 && ok.len() < 180 && ok.iter().all(|i| (0.02..0.05).contains(&bores[*i])));
    let step = ratios[1] - ratios[0];
    // The neighbours beyond both ends are left out: the bore increases with the ratio.
    assert!(ok.windows(2).all(|pair| pair[1] == pair[0] + 1) && bores[ok[0]] < 0.02 + 20.0 * step);
}

#[test]
fn a_constraint_that_cannot_be_is_refused_with_its_line() {
    let refusal = |design: &str, list: &str| {
        let text = text(design, &constrained(list));
        sweep::Study::about(&crate::common::model(), &text).unwrap_err().to_string()
    };
    for (list, expected) in [
        ("\"rod_m < bore_m\"", "expected a list of texts"),
        ("[1]", "expected a list of texts"),
        (
            "[\"rod_m < boer_m\"]",
            "which names `boer_m`, which is no number of the model or of the test; did you mean `bore_m`?",
        ),
        ("[\"rod_m\"]", "compares nothing"),
        ("[\"initial_pressure_pa > 1e4\"]", "which depends on nothing that varies"),
        ("[\"rod_m < hold_time_constants\"]", "this study does not set it"),
        ("[\"rod_m < settling_time_s\"]", "is not known before the row is solved"),
        ("[\"rod_m < 0.001\"]", "leave no row to solve"),
    ] {
        let message = refusal(HEAD, list);
        assert!(
            message.contains(expected) && message.contains("vary.constraints: ") && message.contains("line 1"),
            "{message}"
        );
    }
    let message = refusal("design = \"saltelli\"\nsamples = 64", "[\"rod_m < bore_m\"]");
    assert!(message.contains("indices of a \"saltelli\" design"), "{message}");
}
