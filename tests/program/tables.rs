//! What a run writes and prints: tables, charts and JSON.

use crate::desk::{Desk, HEADER, SHIPPED, STUDY, replaced, rows_of, swept_chart, with};

#[test]
fn a_study_without_sweeps_has_no_swept_columns_and_its_fillers_side_by_side() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(HEADER));
    assert_eq!(
        desk.names("results/study"),
        [
            "chart.png",
            "chart.svg",
            "points.csv",
            "report.html",
            "resolved_study.toml",
            "tallies.lock",
            "tallies.sqlite",
            "written_by_sagnac.jsonl"
        ]
    );
    let chart = desk.read("results/study/chart.svg");
    for label in ["const", "quadratic", "rms error", "99.73 % error"] {
        assert!(chart.contains(&format!(">{label}<")), "{label}");
    }
    let rows = desk.points("results/study");
    let names: Vec<(&str, &str)> =
        rows.iter().map(|row| (row["filler"].as_str(), row["error"].as_str())).collect();
    let (residual, extrapolation) = ("residual", "extrapolation");
    assert_eq!(
        names,
        [
            ("const", residual),
            ("const", extrapolation),
            ("quadratic", residual),
            ("quadratic", extrapolation)
        ]
    );
}

#[test]
fn what_is_not_known_is_blank_and_not_zero() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1");
    for row in desk.points("results/study") {
        for blank in ["rms_se_arcsec", "p99_73_hi_arcsec", "z"] {
            assert_eq!(row[blank], "", "{blank} of {row:?}");
        }
        for known in ["trials", "dt_nu", "mean_arcsec", "rms_arcsec", "max_arcsec", "theory_rms_arcsec"] {
            let value: f64 = row[known].parse().unwrap_or_else(|_| panic!("{known} of {row:?}"));
            assert!(value.is_finite(), "{known} of {row:?}");
        }
    }
}

#[test]
fn a_sweep_without_a_chart_gets_one_and_several_charts_are_numbered() {
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\"]\n";
    let desk = Desk::with(&with(sweep));
    desk.done("run study.toml --device cpu --trials 1000");
    let default = [
        "chart.png",
        "chart.svg",
        "points.csv",
        "report.html",
        "resolved_study.toml",
        "tallies.lock",
        "tallies.sqlite",
        "written_by_sagnac.jsonl",
    ];
    assert_eq!(desk.names("results/study"), default);
    let charts = "[[chart]]\nx = \"dt_nu\"\ny = \"rms\"\n[[chart]]\nx = \"frequency\"\ny = \"max\"\n";
    desk.write("two.toml", &with(&format!("{sweep}{charts}")));
    desk.done("run two.toml --device cpu --trials 1000");
    assert_eq!(desk.names("results/two")[..4], ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]);
}

#[test]
fn maps_are_drawn_with_their_limit_and_what_they_show_is_told() {
    let axes = "x = \"frequency\"\ny = \"amplitude\"\nz = \"p99_73\"\nlimit = \"20 arcsec\"\n";
    let heat = format!("kind = \"heat-map\"\n{axes}where = {{ filler = \"const\" }}\n");
    let winners = format!("kind = \"winner-map\"\n{axes}");
    let text =
        swept_chart(&format!("{heat}[[chart]]\n{winners}")).replace("[chart]\nkind", "[[chart]]\nkind");
    let desk = Desk::with(&text.replace("\"const\", \"quadratic\"", "\"const\", \"linear\", \"quadratic\""));
    let ended = desk.done("run study.toml --device cpu --trials 10000");
    for piece in [
        "chart-1: 3 of the 4 cells are within the limit.",
        "chart-2: 3 of the 4 cells are within the limit; the same in every cell: const = linear.",
    ] {
        assert!(ended.stderr.contains(piece), "{}", ended.stderr);
    }
    assert_eq!(
        desk.names("results/study")[..4],
        ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]
    );
    let heat = desk.read("results/study/chart-1.svg").replace('\u{a0}', " ");
    for piece in ["vibration amplitude, ″/s", "99.73 % error, ″", "within: 75 % of cells", "filler = const"]
    {
        assert!(heat.contains(piece), "{piece} is missing in\n{heat}");
    }
    let winners = desk.read("results/study/chart-2.svg");
    for piece in ["const = linear: 50 % of cells", "quadratic: 50 % of cells", "even the least is over"] {
        assert!(winners.contains(piece), "{piece} is missing in\n{winners}");
    }
}

#[test]
fn a_law_is_a_column_of_the_table_and_a_line_of_the_chart_that_asks_for_it() {
    let chart = "[chart]\nx = \"frequency\"\ny = \"p99_73\"\nlaws = [\"taylor-extremum\", \"noise\"]\n";
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";
    let desk = Desk::with(&with(&format!("{sweep}{chart}")));
    desk.done("run study.toml --device cpu --trials 1000");
    let header =
        format!("motion.frequency_hz,{HEADER},reference_taylor_extremum_arcsec,reference_noise_arcsec");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(header.as_str()));
    let rows = desk.points("results/study");
    let shown = |at: usize| {
        let number = |name: &str| rows[at][name].parse().map_or(String::new(), |x: f64| format!("{x:.2}"));
        (
            rows[at]["filler"].as_str(),
            number("reference_taylor_extremum_arcsec"),
            number("reference_noise_arcsec"),
        )
    };
    // Of the second frequency, Δt·ν = 0.2, σ = 1 ″ and n = 3.
    assert_eq!(shown(4), ("const", "47.37".to_owned(), "4.50".to_owned()));
    assert_eq!(shown(6), ("quadratic", "6.23".to_owned(), String::new()));
    let svg = desk.read("results/study/chart.svg");
    for piece in
        ["Taylor term of one tick at an", "extremum, as published, Z(20)", "3σ noise of const by Z(18),"]
    {
        assert!(svg.contains(piece), "{piece} is missing in\n{svg}");
    }
    desk.write("study.toml", &with(&format!("{sweep}{}", chart.replace("laws", "# laws"))));
    desk.done("run study.toml --device cpu --trials 1000");
    let header = format!("motion.frequency_hz,{HEADER}");
    assert_eq!(desk.read("results/study/points.csv").lines().next(), Some(header.as_str()));
}

#[test]
fn charts_that_are_no_longer_asked_for_are_removed_and_nothing_else() {
    let sweep = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\"]\n";
    let chart = "[[chart]]\nx = \"dt_nu\"\ny = \"rms\"\n";
    let desk = Desk::with(&with(sweep));
    let own = ["chart-02.svg", "chart-0.png", "chart-3.txt", "chart-a.svg", "my-chart.svg"];
    let run = |charts: usize| {
        desk.write("study.toml", &with(&format!("{sweep}{}", chart.repeat(charts))));
        desk.done("run study.toml --device cpu --trials 1000 --quiet");
        for name in own {
            desk.write(&format!("results/study/{name}"), "mine");
        }
        let names = desk.names("results/study");
        names
            .into_iter()
            .filter(|name| name.starts_with("chart") && !own.contains(&name.as_str()))
            .collect::<Vec<_>>()
    };
    assert_eq!(run(1), ["chart.png", "chart.svg"]);
    assert_eq!(run(2), ["chart-1.png", "chart-1.svg", "chart-2.png", "chart-2.svg"]);
    assert_eq!(run(1), ["chart.png", "chart.svg"]);
    for name in own {
        assert_eq!(desk.read(&format!("results/study/{name}")), "mine");
    }
    // Of closed forms with nothing to draw none is left.
    run(2);
    desk.write(
        "study.toml",
        "title = \"none\"\nkind = \"suspension\"\n[suspension]\ngyro = \"LGK-400\"\nfrequency = \"20 Hz\"\n",
    );
    desk.done("run study.toml --out none --quiet");
    assert!(!desk.names("none").iter().any(|name| name.starts_with("chart")));
}

/// Lines of the table on the standard output, split into cells.
fn cells(stdout: &str) -> Vec<Vec<&str>> {
    let lines = stdout.lines().skip_while(|line| !line.contains(", by ")).skip(1);
    let table = lines.take_while(|line| !line.is_empty());
    table.map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()).collect()
}

#[test]
fn the_printed_table_has_a_line_for_every_value_of_every_sweep() {
    let sweep = |key: &str, list: &str| format!("[[sweep]]\nkey = \"{key}\"\nlist = {list}\n");
    let near = sweep("motion.frequency", r#"["20.001 Hz", "20.002 Hz", "25 Hz"]"#);
    let desk = Desk::with(&with(&near));
    let said = desk.done("run study.toml --device cpu --trials 1000 --table").stdout;
    let firsts: Vec<&str> = cells(&said)[1..].iter().map(|line| line[0]).collect();
    assert_eq!(firsts, ["20.001", "20.002", "25"], "{said}");

    let gaps = sweep("switching.gap_ticks", "[1, 2]");
    let rates = sweep("motion.amplitude", r#"["10 arcsec/s", "20 arcsec/s"]"#);
    desk.write("three.toml", &with(&format!("{near}{gaps}{rates}")));
    let said = desk.done("run three.toml --device cpu --trials 1000 --table").stdout;
    let lines = cells(&said);
    assert_eq!(lines.len(), 1 + 3 * 2, "{said}");
    assert_eq!(lines[0][..2], ["vibration frequency, Hz", "vibration amplitude, ″/s"], "{said}");
    let points = desk.points("results/three");
    for line in &lines[1..] {
        let wanted: Vec<f64> = points
            .iter()
            .filter(|row| row["motion.frequency_hz"] == line[0] && row["error"] == "residual")
            .filter(|row| row["motion.amplitude_arcsec_per_s"] == line[1])
            .map(|row| row["rms_arcsec"].parse().unwrap())
            .collect();
        let shown: Vec<f64> = line[2..].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(shown.len(), wanted.len(), "{said}");
        for (shown, wanted) in shown.iter().zip(&wanted) {
            assert!((shown / wanted - 1.0).abs() < 1e-3, "{shown}, {wanted}:\n{said}");
        }
    }

    desk.write(
        "both.toml",
        &with(&format!("{gaps}[chart]\nx = \"gap_ticks\"\ny = \"rms\"\nseries = [\"filler\", \"error\"]\nwhere = {{ gap_ticks = 2 }}")),
    );
    let said = desk.done("run both.toml --device cpu --trials 1000 --table").stdout;
    assert_eq!(cells(&said)[1].len(), 1 + 4, "residual and extrapolation of two fillers:\n{said}");
}

#[test]
fn a_thinned_table_shows_all_values_of_the_faster_sweeps() {
    let study = with(
        "[[sweep]]\nkey = \"motion.frequency\"\nlinear = { from = \"1 Hz\", to = \"50 Hz\", points = 50 }\n\
         [[sweep]]\nkey = \"motion.amplitude\"\nlist = [\"10 arcsec/s\", \"20 arcsec/s\"]\n\
         [chart]\nkind = \"winner-map\"\nx = \"frequency\"\ny = \"amplitude\"\nz = \"rms\"",
    );
    let desk = Desk::with(&study);
    let said = desk.done("run study.toml --device cpu --trials 1 --table").stdout;
    let lines = cells(&said);
    // Two of 34 lines in three are left out, but not the one with the least error of a filler.
    assert!(said.contains("(one line in 3, and those with the least of a column)"), "{said}");
    for rate in ["10", "20"] {
        assert!((17..=18).contains(&lines.iter().filter(|line| line[1] == rate).count()), "{said}");
    }
    let rows = desk.points("results/study");
    for (place, filler) in lines[0].iter().enumerate().skip(2) {
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let of_filler = rows.iter().filter(|row| row["filler"] == *filler && row["error"] == "residual");
        let expected = least(&mut of_filler.map(|row| row["rms_arcsec"].parse().unwrap()));
        let shown = least(&mut lines[1..].iter().map(|line| line[place].parse().unwrap()));
        assert!((shown / expected - 1.0).abs() < 1e-3, "{filler}: {shown}, not {expected}\n{said}");
    }
}

#[test]
fn json_has_the_numbers_of_the_table() {
    let desk = Desk::with(SHIPPED);
    let ended = desk.done("run study.toml --device cpu --trials 1000 --json");
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(
        (json["provenance"]["trials"].as_u64(), json["provenance"]["seed"].as_u64()),
        (Some(1000), Some(1))
    );
    assert_eq!(json["provenance"]["sampled_trials"].as_u64(), Some(72_000));
    let rows = desk.points("results/study");
    let points = rows_of(&json, "points");
    assert_eq!(points.len(), rows.len());
    for (point, row) in points.iter().zip(&rows) {
        assert_eq!(point.as_object().unwrap().len(), row.len());
        for (column, text) in row {
            match &point[column] {
                serde_json::Value::Null => assert_eq!(text, "", "{column}"),
                serde_json::Value::String(string) => assert_eq!(text, string, "{column}"),
                number => {
                    let (number, written) = (number.as_f64().unwrap(), text.parse::<f64>().unwrap());
                    assert!((number - written).abs() <= 1e-8 * number.abs(), "{column}: {number}, {written}");
                }
            }
        }
    }
}

#[test]
fn several_studies_print_one_json_document() {
    let desk = Desk::with(STUDY);
    desk.write("other.toml", &replaced("A study", "Another"));
    let ended = desk.done("run study.toml other.toml --device cpu --trials 1000 --json");
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let titles: Vec<&str> =
        json.as_array().unwrap().iter().map(|one| one["title"].as_str().unwrap()).collect();
    assert_eq!(titles, ["A study", "Another"]);
}
