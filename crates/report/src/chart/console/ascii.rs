//! Replacement of the characters of charts by plain ASCII.

use crate::chart::ticks::raised_signs;

/// Other characters, replaced by words where there is no similar one.
const OTHERS: [(char, &str); 20] = [
    ('″', "arcsec"),
    ('′', "arcmin"),
    ('°', "deg"),
    ('√', "sqrt "),
    ('·', "*"),
    ('−', "-"),
    ('–', "-"),
    ('…', "..."),
    ('×', "x"),
    ('Δ', "d"),
    ('δ', "d"),
    ('σ', "sigma"),
    ('τ', "tau"),
    ('ν', "nu"),
    ('χ', "chi"),
    ('φ', "phi"),
    ('α', "alpha"),
    ('λ', "lambda"),
    ('µ', "u"),
    ('Ω', "Omega"),
];

/// The text in ASCII: `10⁻²` becomes `1e-2`, `(°/h)²` becomes `(deg/h)^2`; a character without a replacement becomes
/// `?`.
pub fn spelled(text: &str) -> String {
    let mut out = String::new();
    let mut raised = false;
    for sign in text.chars() {
        if let Some((_, plain)) = raised_signs().find(|(known, _)| *known == sign) {
            if !raised {
                begin_exponent(&mut out);
            }
            raised = true;
            out.push(plain);
            continue;
        }
        raised = false;
        match OTHERS.iter().find(|(known, _)| *known == sign) {
            Some((_, word)) => out += word,
            None if sign.is_ascii() => out.push(sign),
            None => out.push('?'),
        }
    }
    out
}

/// Powers of ten are written as numbers, other powers with `^`.
fn begin_exponent(out: &mut String) {
    if let Some(number) = out.strip_suffix("*10") {
        *out = format!("{number}e");
    } else if out.ends_with("10") && !out[..out.len() - 2].ends_with(|c: char| c.is_ascii_digit()) {
        out.truncate(out.len() - 2);
        *out += "1e";
    } else {
        out.push('^');
    }
}

#[cfg(test)]
mod tests {
    use crate::chart::console::ascii::spelled;

    #[test]
    fn powers_units_and_letters_have_a_spelling() {
        assert_eq!(spelled("10⁻²"), "1e-2");
        assert_eq!(spelled("2·10¹²"), "2e12");
        assert_eq!(spelled("Allan variance, (°/h)²"), "Allan variance, (deg/h)^2");
        assert_eq!(spelled("−0.5 °/√h …"), "-0.5 deg/sqrt h ...");
        assert_eq!(spelled("Яu"), "?u");
        assert!(spelled("rms error, ″").is_ascii());
    }
}
