//! The files of the measured gas spring, unmodified, read through a rig's mapping. Skipped if the data is absent.

use records::Rig;
use std::path::Path;

#[test]
fn a_logger_s_file_is_read_as_it_is() {
    let Ok(data) = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/mbari").canonicalize() else {
        println!("skipped: the gas spring's records are not in ../shared/data/mbari");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let rig = format!(
        r#"
        [cylinder]
        area_m2 = 0.0127
        stroke_m = 2.03
        [gas]
        name = "nitrogen"
        [columns]
        time = {{ name = "time(s)", unit = "s" }}
        pressure = {{ name = "UpperSpringPressure(psia)", unit = "psi", reference = "absolute" }}
        position = {{ name = "Pos(in)", unit = "in" }}
        [format]
        separator = "whitespace"
        [[experiment]]
        name = "friction"
        traces = ['{0}/FrictionIDMovesWithBiasCurr.exp']
        [[experiment]]
        name = "moves"
        traces = ['{0}/2021.07.26T10.51.44.exp']
        to_s = 100
        "#,
        data.display()
    );
    std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
    let rig = Rig::read(folder.path()).unwrap();
    let [friction, moves] = &rig.experiments[..] else { panic!("two experiments") };
    let trace = &friction.traces[0];
    assert_eq!((trace.len(), trace.time_s[0], trace.time_s[20000]), (20001, 0.0, 400.0));
    assert!((trace.position_m[0] - 3.070 * 0.0254).abs() < 1e-12);
    assert!((trace.pressure_pa.as_ref().unwrap()[0] / (87.0 * 6894.757293168361) - 1.0).abs() < 1e-14);
    assert_eq!(moves.traces[0].len(), 5001);
}
