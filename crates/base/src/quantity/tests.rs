use super::*;

fn parse_any(text: &str) -> Result<Quantity, UnitError> {
    parse(text, &Dimension::ALL)
}

fn value(text: &str) -> f64 {
    parse_any(text).unwrap_or_else(|error| panic!("{text}: {error}")).value
}

#[test]
fn quantities_come_out_in_arcseconds_and_seconds() {
    let table = [
        ("5 ms", 0.005),
        ("5ms", 0.005),
        ("50_000 µs", 0.05),
        ("7 us", 7e-6),
        ("7 μs", 7e-6),
        ("2 min", 120.0),
        ("1.5 h", 5400.0),
        ("20 Hz", 20.0),
        ("20 1/s", 20.0),
        ("0.02 kHz", 20.0),
        ("2e1 Hz", 20.0),
        ("+2.5E-3 kHz", 2.5),
        ("−3 ″", -3.0),
        ("3 \"", 3.0),
        ("2 ′", 120.0),
        ("2 arcmin", 120.0),
        ("1°", 3600.0),
        ("1 rad", 206_264.806_247),
        ("1 mrad", 206.264_806_247),
        ("1 µrad", 0.206_264_806_247),
        ("1 urad", 0.206_264_806_247),
        ("1 deg/s", 3600.0),
        ("1 °/h", 1.0),
        ("1 deg/sqrt(h)", 60.0),
        ("1 deg/√h", 60.0),
        ("1 deg * h^-1", 1.0),
        ("0.003 deg/sqrt(h)", 0.18),
        ("1 deg/h/sqrt(Hz)", 1.0),
        ("60 °/h/√(Hz)", value("1 °/√h")),
        ("1 dps", value("1 deg/s")),
        ("4 mdps/√Hz", value("4 mdeg/s/sqrt(Hz)")),
        ("4 mdps/rtHz", value("4 mdeg/s/sqrt(Hz)")),
        ("4 mdps/sqrtHz", value("4 mdeg/s/sqrt(Hz)")),
        ("5 dph/rt(Hz)", value("5 °/h/√Hz")),
        ("0.1 deg/rthr", value("0.1 °/√h")),
        ("0.1 deg/rtHr", value("0.1 °/√h")),
        ("3 °/hr", value("3 °/h")),
        ("9.80665 m/s^2", 1.0),
        ("9806.65 mm/s", 1.0),
        ("980665 mGal", 1.0),
        ("5 mg", 0.005),
        ("9.80665 km", 1000.0),
        ("36 km/h", value("10 m/s")),
        ("1 nmi/h", value("1 kn")),
        ("1 nmi", value("1852 m")),
    ];
    for (text, expected) in table {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn densities_and_roots_reduce_to_base_units() {
    let table = [
        ("deg/h/sqrt(h)", 1.0 / 60.0, [2, -3, 0, 0]),
        ("(deg/s)^2/Hz", 12_960_000.0, [4, -2, 0, 0]),
        ("g^2/Hz", 1.0, [0, 2, 4, 0]),
        ("arcsec/pulse", 1.0, [2, 0, 0, -2]),
        ("pulses", 1.0, [0, 0, 0, 2]),
        ("g·s/√(Hz)", 1.0, [0, 3, 2, 0]),
    ];
    for (text, factor, exponents) in table {
        let size = expression::parse(text).unwrap();
        assert!((size.factor / factor - 1.0).abs() < 1e-14, "{text}: {}", size.factor);
        assert_eq!(size.exponents, Exponents(exponents), "{text}");
    }
}

#[test]
fn what_is_no_quantity_is_named() {
    let table = [
        ("20", "bare number"),
        ("Hz", "does not begin with a number"),
        ("", "does not begin with a number"),
        ("nan Hz", "does not begin with a number"),
        ("inf s", "does not begin with a number"),
        ("1e999 Hz", "not a finite number"),
        ("5,0 deg/s", "write decimals with a point and thousands without a sign, as in \"5.0 deg/s\""),
        ("-0,5 ″", "as in \"-0.5 ″\""),
        ("1,000,000 Hz", "as in \"1000000 Hz\""),
        ("12,000 Hz", "as in \"12.000 Hz\" or \"12000 Hz\""),
        ("12,000.5 Hz", "as in \"12000.5 Hz\""),
        ("5, Hz", "cannot be read"),
        ("5 sec", "`sec` is not a known unit"),
        ("5 hz", "`hz` is not a known unit"),
        ("5 deg/", "`deg/` cannot be read"),
        ("5 deg/sqrt(h", "cannot be read"),
        ("5 sqrt(sqrt(h))", "cannot be read"),
        ("5 deg^99999999999", "cannot be read"),
        ("5 deg deg", "cannot be read"),
        ("3 deg/h^3", "is a quantity in ″·s^-3"),
        ("3 g s", "cannot be read"),
        ("3 g·s^3", "is a quantity in s^3·g"),
    ];
    for (text, piece) in table {
        let error = parse_any(text).unwrap_err().to_string();
        assert!(error.contains(piece), "{text}: {error}");
    }
    assert!(expression::parse(&"(".repeat(100_000)).is_err());
    let error = parse("5 ms", &[Dimension::Frequency]).unwrap_err();
    assert_eq!(error.to_string(), "\"5 ms\" is a time");
}

#[test]
fn tables_show_what_is_on_the_earth_in_the_units_of_navigators() {
    for (text, dimension, shown) in [
        ("463 m", Dimension::Distance, "0.25 nmi"),
        ("36 km/h", Dimension::Speed, "10 m/s"),
        ("60 ′", Dimension::Bearing, "1°"),
    ] {
        let quantity = parse(text, &[dimension]).unwrap();
        assert_eq!(Quantity { written: None, ..quantity }.to_string(), shown);
        assert_eq!(quantity.to_string(), text);
    }
}

#[test]
fn quantities_are_written_in_their_unit() {
    for text in ["200 °/s", "0.0013 °/h", "14 ″/s", "5 s", "2 kHz", "10″"] {
        let dimensions = [Dimension::Rate, Dimension::Time, Dimension::Frequency, Dimension::Angle];
        assert_eq!(parse(text, &dimensions).unwrap().to_string(), text);
    }
    assert_eq!(parse("0.01 deg/h", &[Dimension::DriftRate]).unwrap().to_string(), "0.01 °/h");
}

#[test]
fn values_keep_twelve_digits() {
    assert_eq!(round_12(0.1 + 0.2), 0.3);
    assert_eq!(round_12(1.0 / 3.0), 0.333_333_333_333);
    assert_eq!(round_12(-2e300 / 3.0), -6.666_666_666_67e299);
}
