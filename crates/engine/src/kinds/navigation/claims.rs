//! The columns of the consistency of a filter.

use crate::kinds::navigation::columns::Row;
use crate::kinds::navigation::run::claim::Claim;
use sagnac_base::table::{Cell, ColumnOf, Role, Unit};

fn of(row: &Row, value: impl Fn(&Claim) -> Option<f64>) -> Cell {
    row.claim.as_ref().and_then(value).into()
}

/// The columns of a solution with a filter, after those of the heading.
#[rustfmt::skip]
pub(crate) fn claims<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("claimed", Unit::ARCSEC, "error of the heading claimed by the filter, σ", |row| of(row, |claim| Some(claim.sigma)))
            .is(Role::Estimate, "Standard deviation of the heading that the filter claims, ″, of its own model."),
        Of::new("nees", Unit::NONE, "mean squared error over claimed variance (NEES)", |row| of(row, |claim| claim.nees))
            .is(Role::Estimate, "Normalized estimation error squared: mean squared error of the heading over the variance that the filter claims. 1 is \
                consistent, more is too sure, less too careful.")
            .within(|row| row.claim.as_ref().and_then(Claim::nees_band)),
        Of::new("nees_se", Unit::NONE, "NEES, standard error", |row| of(row, |claim| claim.nees_se))
            .is_of("nees", Role::StandardError, "Standard error (1 σ) of `nees`."),
        Of::new("nees_lo", Unit::NONE, "NEES (lower)", |row| of(row, |claim| claim.nees_band().map(|ends| ends.0)))
            .is_of("nees", Role::Lower, "Lower end of the 95 % interval of `nees`."),
        Of::new("nees_hi", Unit::NONE, "NEES (upper)", |row| of(row, |claim| claim.nees_band().map(|ends| ends.1)))
            .is_of("nees", Role::Upper, "Upper end of the 95 % interval of `nees`."),
        Of::new("theory_nees", Unit::NONE, "NEES (closed form)", |row| of(row, |claim| Some(claim.closed_nees)))
            .is_of("nees", Role::Theory, "`nees` in closed form, wᵀCw over the claimed variance."),
        Of::new("nees_z", Unit::NONE, "NEES, deviation from the closed form, standard errors", |row| of(row, |claim| claim.z))
            .is_of("nees", Role::Z, "Deviation of `nees` from its closed form in standard errors; beyond ±5 something is wrong."),
        Of::new("within95", Unit::NONE, "part of trials within the filter's 95 % region", |row| of(row, |claim| claim.within))
            .is(Role::Estimate, "Part of the trials whose error is within 1.96 σ of the filter's own claim; 0.95 if it is consistent.")
            .within(|row| row.claim.as_ref().and_then(|claim| claim.within_band)),
        Of::new("within95_lo", Unit::NONE, "part within the 95 % region (lower)", |row| of(row, |claim| claim.within_band.map(|ends| ends.0)))
            .is_of("within95", Role::Lower, "Lower end of the 95 % interval of `within95` (Wilson)."),
        Of::new("within95_hi", Unit::NONE, "part within the 95 % region (upper)", |row| of(row, |claim| claim.within_band.map(|ends| ends.1)))
            .is_of("within95", Role::Upper, "Upper end of the 95 % interval of `within95` (Wilson)."),
        Of::new("theory_within95", Unit::NONE, "part within the 95 % region (closed form)", |row| of(row, |claim| Some(claim.closed_within)))
            .is_of("within95", Role::Theory, "`within95` for normally distributed errors with the mean and variance in closed form."),
    ]
}
