//! The parts of a drift budget.

use crate::drift::Drift;
use crate::study::Part;

/// All parts.
pub(crate) static PARTS: [Part<Drift>; 3] = [
    Part { name: "magnetic drift", off: |drift| (drift.magnetic, drift.initial_magnetic) = (0.0, 0.0) },
    Part { name: "non-magnetic drift", off: |drift| drift.non_magnetic = 0.0 },
    Part { name: "residuals of the switches", off: |drift| drift.residual_max = 0.0 },
];
