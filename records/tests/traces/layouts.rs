//! Files of every layout are read without conversion: separators, headers, comments, encodings, decimal commas.

use crate::{Bench, GOOD, assert_says, table};

#[test]
fn plain_columns_are_read_with_every_bit() {
    let trace = Bench::new().read(table(&GOOD)).unwrap();
    assert_eq!(trace.time_s, [0.0, 0.01, 0.02, 0.03]);
    assert_eq!(trace.pressure_pa.as_deref(), Some(&[101300.0, 101310.5, 150000.0, 200000.0][..]));
    assert_eq!(trace.position_m, [0.1, 0.1, 0.08, 0.05]);
    assert_eq!(trace.ambient_temperature_k, None);
    assert_eq!(trace.sha256.len(), 64);
}

#[test]
fn byte_order_mark_line_ends_quotes_and_blank_lines_do_not_matter() {
    let bench = Bench::new();
    let plain = bench.read(table(&GOOD)).unwrap();
    let dressed = "\u{feff}\"time_s\" , \"pressure_pa\",position_m,\"note, unread\"\r\n\
                   0.0,\"101300\",0.1,start\r\n0.01, 101310.5 ,0.1,\r\n\r\n0.02,1.5e5,0.08,\"a \"\"b\"\", c\"\r\n\
                   +0.03,200000,5e-2,end\r\n\r\n  \r\n";
    let trace = bench.read(dressed).unwrap();
    assert_eq!(
        (trace.time_s, trace.pressure_pa, trace.position_m),
        (plain.time_s, plain.pressure_pa, plain.position_m)
    );
}

#[test]
fn a_file_without_a_last_line_end_loses_nothing() {
    assert_eq!(Bench::new().read(table(&GOOD).trim_end()).unwrap().len(), 4);
}

#[test]
fn a_hash_before_a_header_with_commas_over_blank_separated_rows() {
    let bench = Bench::with_rig(
        "[columns]\ntime = { name = \"time(s)\" }\npressure = { name = \"P(psia)\", unit = \"psi\" }\n\
         position = { name = \"Pos(in)\", unit = \"in\" }\n[format]\nseparator = \"whitespace\"\n",
    );
    let trace = bench.read("#time(s),Pos(in),P(psia)\n  0.00 4.0 14.7\n  0.02  3.0 15\n  0.04\t2.0 16\n").unwrap();
    assert_eq!(trace.time_s, [0.0, 0.02, 0.04]);
    assert!((trace.position_m[2] - 0.0508).abs() < 1e-15);
    let spaced = bench.read("# time(s) Pos(in) P(psia)\n0 4 14.7\n1 3 15\n2 2 16\n").unwrap();
    assert_eq!(spaced.time_s, [0.0, 1.0, 2.0]);
}

#[test]
fn a_wrong_decimal_sign_is_named() {
    let german = ["0,00;1,0130;100,0", "0,01;1,0131;100,0", "0,02;1,5000;80,0", "0,03;2,0000;50,0"];
    let columns = "[columns]\ntime = { name = \"Zeit\" }\npressure = { name = \"Druck\", unit = \"bar\" }\n\
                   position = { name = \"Weg\", unit = \"mm\" }\n";
    let text = format!("Zeit;Druck;Weg\n{}\n", german.join("\n"));
    let stated = |format: &str| Bench::with_rig(&format!("{columns}[format]\n{format}\n"));
    let commas = ["line 2: the numbers have decimal commas; say decimal = \",\" in the rig's [format]"];
    assert_says(&stated("decimal = \".\"").refusal(&text), &commas);
    let points = text.replace(',', ".").replace(';', ",");
    let says = ["line 2, column `Zeit`", "for decimal points say decimal = \".\" in the rig's [format]"];
    assert_says(&stated("decimal = \",\"").refusal(points), &says);
    assert_eq!(stated("decimal = \",\"").read(&text).unwrap().len(), 4);
    // A column missing with either decimal sign is the cause itself.
    let message = stated("decimal = \".\"").refusal(text.replace("Zeit", "t"));
    assert_says(&message, &["there is no column `Zeit`"]);
}

#[test]
fn separators_are_found_and_a_wrong_one_is_named() {
    let plain = Bench::new().read(table(&GOOD)).unwrap();
    for separator in [";", "\t", " ", "   "] {
        let trace = Bench::new().read(table(&GOOD).replace(',', separator)).unwrap();
        assert_eq!((&trace.time_s, &trace.pressure_pa), (&plain.time_s, &plain.pressure_pa), "{separator:?}");
    }
    let stated = Bench::with_rig("[format]\nseparator = \";\"\n");
    assert_says(&stated.refusal(table(&GOOD)), &["line 1", "no column `time_s`", "leave out separator"]);
}

#[test]
fn decimal_commas_are_recognised() {
    let message = Bench::new().refusal(table(&["0,00,101300,0,100000,1"]));
    assert_says(&message, &["line 2", "fields where the header names 3", "decimal commas"]);
    let points = Bench::with_rig("[format]\nseparator = \";\"\ndecimal = \".\"\n");
    let message = points.refusal("time_s;pressure_pa;position_m\n0,01;1e5;0,1\n");
    assert_says(&message, &["line 2, column `time_s`", "`0,01`", "decimal = \",\""]);
    let commas = Bench::new().read(table(&GOOD).replace(',', ";").replace('.', ",")).unwrap();
    assert_eq!(commas.pressure_pa, Bench::new().read(table(&GOOD)).unwrap().pressure_pa);
}

#[test]
fn header_blocks_comments_and_encodings_do_not_matter() {
    let plain = Bench::new().read(table(&GOOD)).unwrap();
    let text = format!("Prüfstand 3\nNotes, by hand\n\n# Größe\n{}", table(&GOOD).replace("0.02,", "# hold\n0.02,"));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [text.as_bytes(), &latin, &wide, &[b"\xff\xfe", &wide[..]].concat()] {
        let trace = Bench::new().read(bytes).unwrap();
        assert_eq!((&trace.time_s, &trace.pressure_pa), (&plain.time_s, &plain.pressure_pa));
        assert!(trace.dropped_rows.is_empty());
    }
    let format = "[format]\nskip_lines = 3\ncomment = \"#\"\ndecimal = \".\"\nencoding = \"latin-1\"\n";
    assert_eq!(Bench::with_rig(format).read(latin).unwrap().time_s, plain.time_s);
}

#[test]
fn a_file_without_a_header_has_numbered_columns() {
    let column = |quantity: &str, k: usize| format!("{quantity} = {{ name = \"column {k}\" }}\n");
    let columns = [column("time", 1), column("pressure", 3), column("position", 2)].concat();
    let trace = Bench::with_rig(&format!("[columns]\n{columns}")).read("0 0.1 1e5\n1 0.1 1e5\n2 0.1 1e5\n").unwrap();
    assert_eq!((trace.position_m, trace.pressure_pa.unwrap()), (vec![0.1; 3], vec![1e5; 3]));
}
