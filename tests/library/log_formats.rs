//! Every format of recorded data gives the same samples, with the same gap.

use crate::formats::{BINARIES, TEXT, bits};

#[test]
fn every_format_gives_the_bits_of_the_text() {
    let text = TEXT.read(&TEXT.path()).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    assert_eq!((text.samples(), text.channels.len()), (43, 3));
    assert!((15..22).all(|row| text.channels[0].samples[row].is_nan()), "{text:?}");
    for sample in &BINARIES {
        let log = sample.read(&sample.path()).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
        assert_eq!(bits(&log), bits(&text), "{}", sample.file);
        assert!((log.step_s / 0.005 - 1.0).abs() < 1e-6, "{}: {} s", sample.file, log.step_s);
    }
}
