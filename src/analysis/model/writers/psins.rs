//! Errors of an IMU for PSINS.

use crate::analysis::model::writers::{Takes, Writer, list, sigma, three, time_s};

pub(super) static PSINS: Writer = Writer {
    name: "psins",
    file: "psins_imuerr.m",
    tool: "PSINS",
    convention: "arguments of imuerrset(): web in deg/sqrt(h) and wdb in ug/sqrt(Hz), of two-sided densities; sqrtR0G in deg/h and sqrtR0A in ug are \
                 stationary standard deviations with correlation times TauG and TauA in s",
    takes: Takes::STATE,
    text: |sheet| {
        let column = |name: &str, values: [f64; 3]| format!("{name} = [{}];\n", list(values, "; "));
        let (gyros, accelerometers) = (&sheet.gyros, &sheet.accelerometers);
        sheet.comments("%")
            + "% Constant biases eb and db are those of turn-on, which a record does not show.\n"
            + &column("eb", [0.0; 3])
            + &column("db", [0.0; 3])
            + &column("web", three(gyros, |model| model.white / 60.0))
            + &column("wdb", three(accelerometers, |model| model.white))
            + &column("sqrtR0G", three(gyros, sigma))
            + &column("TauG", if gyros.is_empty() { [1.0; 3] } else { three(gyros, time_s) })
            + &column("sqrtR0A", three(accelerometers, sigma))
            + &column(
                "TauA",
                if accelerometers.is_empty() { [1.0; 3] } else { three(accelerometers, time_s) },
            )
            + "imuerr = imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA);\n"
    },
};
