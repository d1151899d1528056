//! Unit expressions: `deg/h/sqrt(Hz)`, `(deg/s)^2/Hz`, `°/√h`.
//!
//! ```text
//! expression = power { ("/" | "*" | "·") power }        left to right
//! power      = primary [ "^" ["-"] digits ]
//! primary    = "(" expression ")" | root "(" expression ")" | root symbol | "√" primary | "1" | symbol
//! root       = "sqrt" | "rt"
//! ```

use std::fmt;
use std::sync::LazyLock;

use crate::quantity::UnitError;

/// Arcseconds in one radian: 180 · 3600 / π.
const ARCSEC_PER_RAD: f64 = 206_264.806_247_096_36;

/// Standard acceleration of free fall, m/s² in one g, exactly: CGPM 1901.
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// One international nautical mile, m, exactly.
pub const NAUTICAL_MILE: f64 = 1852.0;

/// One metre in g·s².
const METRE: f64 = 1.0 / STANDARD_GRAVITY;

/// Longest expression read: far above any sensible unit, and a bound on the depth of the recursion.
const MAX_EXPRESSION: usize = 64;

/// Powers of the base units ″, s, g and pulse, counted in halves so that roots stay whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exponents(pub [i32; 4]);

impl Exponents {
    const NONE: Exponents = Exponents([0; 4]);

    fn times(self, power: i32) -> Exponents {
        Exponents(self.0.map(|halves| halves.saturating_mul(power)))
    }

    fn plus(self, other: Exponents) -> Exponents {
        Exponents(std::array::from_fn(|i| self.0[i].saturating_add(other.0[i])))
    }
}

impl fmt::Display for Exponents {
    /// In base units: `″·s^-0.5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symbols = ["″", "s", "g", "pulse"];
        let mut dot = "";
        for (symbol, halves) in symbols.iter().zip(self.0).filter(|(_, halves)| *halves != 0) {
            match halves {
                2 => write!(f, "{dot}{symbol}")?,
                _ => write!(f, "{dot}{symbol}^{}", f64::from(halves) / 2.0)?,
            }
            dot = "·";
        }
        Ok(())
    }
}

/// The size of a unit in base units, with their powers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// The size in base units.
    pub factor: f64,
    /// The powers of the base units.
    pub exponents: Exponents,
}

/// All symbols, each with its size in base units and the powers (in halves) of ″, s, g, pulse.
const SYMBOLS: [(&[&str], f64, [i32; 4]); 32] = [
    (&["s"], 1.0, [0, 2, 0, 0]),
    (&["ms"], 1e-3, [0, 2, 0, 0]),
    (&["us", "µs", "μs"], 1e-6, [0, 2, 0, 0]),
    (&["ns"], 1e-9, [0, 2, 0, 0]),
    (&["min"], 60.0, [0, 2, 0, 0]),
    (&["h", "hr", "Hr"], 3600.0, [0, 2, 0, 0]),
    (&["Hz"], 1.0, [0, -2, 0, 0]),
    (&["kHz"], 1e3, [0, -2, 0, 0]),
    (&["arcsec", "″", "\""], 1.0, [2, 0, 0, 0]),
    (&["arcmin", "′"], 60.0, [2, 0, 0, 0]),
    (&["deg", "°"], 3600.0, [2, 0, 0, 0]),
    (&["mdeg"], 3.6, [2, 0, 0, 0]),
    (&["rad"], ARCSEC_PER_RAD, [2, 0, 0, 0]),
    (&["mrad"], ARCSEC_PER_RAD * 1e-3, [2, 0, 0, 0]),
    (&["urad", "µrad", "μrad"], ARCSEC_PER_RAD * 1e-6, [2, 0, 0, 0]),
    (&["dps"], 3600.0, [2, -2, 0, 0]),
    (&["mdps"], 3.6, [2, -2, 0, 0]),
    (&["dph"], 1.0, [2, -2, 0, 0]),
    (&["g"], 1.0, [0, 0, 2, 0]),
    (&["mg"], 1e-3, [0, 0, 2, 0]),
    (&["ug", "µg", "μg"], 1e-6, [0, 0, 2, 0]),
    (&["m"], METRE, [0, 4, 2, 0]),
    (&["cm"], METRE * 1e-2, [0, 4, 2, 0]),
    (&["mm"], METRE * 1e-3, [0, 4, 2, 0]),
    (&["ft"], METRE * 0.3048, [0, 4, 2, 0]),
    (&["km"], METRE * 1e3, [0, 4, 2, 0]),
    (&["nmi"], METRE * NAUTICAL_MILE, [0, 4, 2, 0]),
    (&["kn"], METRE * NAUTICAL_MILE / 3600.0, [0, 2, 2, 0]),
    (&["Gal"], METRE * 1e-2, [0, 0, 2, 0]),
    (&["mGal"], METRE * 1e-5, [0, 0, 2, 0]),
    (&["uGal", "µGal", "μGal"], METRE * 1e-8, [0, 0, 2, 0]),
    (&["pulse", "pulses"], 1.0, [0, 0, 0, 2]),
];

/// Units in which quantities are shown as they are written, each with its symbol.
const SHOWN: [(&str, &str); 22] = [
    ("arcsec", "″"),
    ("arcmin", "′"),
    ("deg", "°"),
    ("mdeg", "m°"),
    ("rad", "rad"),
    ("mrad", "mrad"),
    ("µrad", "µrad"),
    ("arcsec/s", "″/s"),
    ("deg/s", "°/s"),
    ("deg/h", "°/h"),
    ("rad/s", "rad/s"),
    ("deg/s^2", "°/s²"),
    ("Hz", "Hz"),
    ("kHz", "kHz"),
    ("g", "g"),
    ("mg", "mg"),
    ("m/s^2", "m/s²"),
    ("km/h", "km/h"),
    ("kn", "kn"),
    ("km", "km"),
    ("m", "m"),
    ("m/s", "m/s"),
];

/// The symbol of a unit of this size; `None` for one that is not shown as it is written. Of symbols of the same size, as ″/s and
/// °/h, it is that of the unit `text`.
pub fn symbol(text: &str, size: Size) -> Option<&'static str> {
    static SIZES: LazyLock<Vec<(Size, &str)>> = LazyLock::new(|| {
        SHOWN.iter().filter_map(|(text, symbol)| Some((parse(text).ok()?, *symbol))).collect()
    });
    let is_in_degrees = text.starts_with("deg") || text.starts_with('°');
    let mut symbols = SIZES.iter().filter(|(known, _)| *known == size).map(|(_, symbol)| *symbol);
    let first = symbols.next()?;
    Some(symbols.find(|_| is_in_degrees).unwrap_or(first))
}

/// Reads a whole unit expression.
///
/// # Errors
/// A symbol is not a unit, or the text is not an expression.
pub fn parse(text: &str) -> Result<Size, UnitError> {
    let malformed = || UnitError::Malformed(text.to_owned());
    if text.chars().count() > MAX_EXPRESSION {
        return Err(malformed());
    }
    let mut parser = Parser { whole: text, rest: text };
    let size = parser.expression()?;
    if parser.rest.trim_start().is_empty() { Ok(size) } else { Err(malformed()) }
}

struct Parser<'a> {
    whole: &'a str,
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn expression(&mut self) -> Result<Size, UnitError> {
        let mut product = self.power()?;
        loop {
            let divides = self.eat("/");
            if !divides && !self.eat("*") && !self.eat("·") {
                return Ok(product);
            }
            let Size { factor, exponents } = self.power()?;
            let (factor, power) =
                if divides { (product.factor / factor, -1) } else { (product.factor * factor, 1) };
            product = Size { factor, exponents: product.exponents.plus(exponents.times(power)) };
        }
    }

    fn power(&mut self) -> Result<Size, UnitError> {
        let base = self.primary()?;
        if !self.eat("^") {
            return Ok(base);
        }
        let negative = self.eat("-");
        let digits = self.take_while(|c| c.is_ascii_digit());
        let power: i32 = digits.parse().map_err(|_| self.malformed())?;
        let power = if negative { -power } else { power };
        Ok(Size { factor: libm::pow(base.factor, f64::from(power)), exponents: base.exponents.times(power) })
    }

    fn primary(&mut self) -> Result<Size, UnitError> {
        if self.eat("√") {
            let under = self.primary()?;
            return self.root(under);
        }
        if self.eat("(") {
            return self.closed();
        }
        if self.eat("1") {
            return Ok(Size { factor: 1.0, exponents: Exponents::NONE });
        }
        match self.symbol() {
            "" => Err(self.malformed()),
            "sqrt" | "rt" if self.eat("(") => {
                let under = self.closed()?;
                self.root(under)
            }
            symbol => match lookup(symbol) {
                Some(size) => Ok(size),
                // As in mdps/rtHz.
                None => {
                    let under = symbol.strip_prefix("sqrt").or_else(|| symbol.strip_prefix("rt"));
                    let under =
                        under.and_then(lookup).ok_or_else(|| UnitError::Unknown(symbol.to_owned()))?;
                    self.root(under)
                }
            },
        }
    }

    /// Reads the rest of a parenthesis.
    fn closed(&mut self) -> Result<Size, UnitError> {
        let inner = self.expression()?;
        if self.eat(")") { Ok(inner) } else { Err(self.malformed()) }
    }

    /// Takes a square root. Fourth roots do not occur in the data sheet of a gyro and are refused.
    fn root(&self, Size { factor, exponents }: Size) -> Result<Size, UnitError> {
        if exponents.0.iter().any(|halves| halves % 2 != 0) {
            return Err(self.malformed());
        }
        let exponents = Exponents(exponents.0.map(|halves| halves / 2));
        Ok(Size { factor: libm::sqrt(factor), exponents })
    }

    /// Reads a word, or one of the signs ″ " ′ °.
    fn symbol(&mut self) -> &'a str {
        self.rest = self.rest.trim_start();
        match self.rest.chars().next() {
            Some(sign @ ('″' | '"' | '′' | '°')) => self.split(sign.len_utf8()),
            _ => self.take_while(char::is_alphabetic),
        }
    }

    fn eat(&mut self, token: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(token);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn take_while(&mut self, keep: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !keep(c)).unwrap_or(self.rest.len());
        self.split(end)
    }

    fn split(&mut self, end: usize) -> &'a str {
        let (head, tail) = self.rest.split_at(end);
        self.rest = tail;
        head
    }

    fn malformed(&self) -> UnitError {
        UnitError::Malformed(self.whole.to_owned())
    }
}

fn lookup(symbol: &str) -> Option<Size> {
    let found = SYMBOLS.iter().find(|(names, ..)| names.contains(&symbol));
    found.map(|&(_, factor, exponents)| Size { factor, exponents: Exponents(exponents) })
}
