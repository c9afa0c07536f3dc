pub fn load(folder: &str) -> records::Rig {
    let text = std::fs::read_to_string(format!("{folder}/rig.toml")).unwrap();
    let num = |k: &str| text.lines().find(|l| l.starts_with(k)).and_then(|l| l.split('=').nth(1)).and_then(|v| v.split('#').next().unwrap().trim().parse::<f64>().ok());
    let bore = num("bore_m").unwrap();
    let exps = ["compress-ambient", "compress-3bar", "expand-5bar", "expand-ambient", "compress-part"];
    let experiments = exps.iter().map(|e| records::Experiment { name: e.to_string(), traces: (1..=3).map(|k| {
        let path = format!("{folder}/{e}-{k}.csv");
        let t = std::fs::read_to_string(&path).unwrap();
        let col: Vec<Vec<f64>> = t.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        let c = |i: usize| col.iter().map(|r| r[i]).collect::<Vec<f64>>();
        records::Trace { path: path.into(), sha256: String::new(), time_s: c(0), pressure_pa: Some(c(1)), position_m: c(2), ambient_temperature_k: Some(c(3)), gas_temperature_k: None, mass_flow_kg_per_s: None }
    }).collect() }).collect();
    records::Rig { path: folder.into(), cylinder: records::Cylinder { bore_m: bore, rod_through_m: 0.0, piston_area_m2: bore*bore*std::f64::consts::FRAC_PI_4, stroke_m: None }, dead_volume: None, ambient: records::Ambient { temperature_k: num("temperature_k"), pressure_pa: 101300.0 }, gas: records::NamedGas { name: Some("air".into()), gas: chamber::Gas::AIR }, sensor: records::Sensor { noise_pa: Some(150.0), sample_rate_hz: None }, experiments }
}
