//! The parameter words of a kernel, declared once for Rust and for its shader.

/// Declares parameter words from their fields in order, each with its length for the `Shape` in scope. The lengths
/// determine the places of the fields in the shader.
macro_rules! parameters {
    ($($(#[$doc:meta])* $field:ident: $length:expr),* $(,)?) => {
        /// The fixed-point image of a point, one field after the other, as the kernel sees it.
        #[derive(Debug, Clone, Copy)]
        pub struct Parameters<'a> { $($(#[$doc])* pub $field: &'a [u32]),* }

        impl<'a> Parameters<'a> {
            /// Splits `words`, which must have the length that `shape` requires, into its fields.
            #[inline(always)]
            #[allow(unused_assignments)]
            pub fn new(words: &'a [u32], shape: Shape) -> Parameters<'a> {
                let mut from = 0;
                $(let length = ($length)(shape); let $field = &words[from..from + length]; from += length;)*
                Parameters { $($field),* }
            }

            /// The words of all fields.
            pub fn words(&self) -> Vec<u32> {
                [$(self.$field),*].concat()
            }
        }

        /// The place of each field among the words, as constants of a shader.
        pub(crate) fn wgsl_places(shape: Shape) -> String {
            let (mut text, mut from) = (String::new(), 0);
            $(
                text += &format!("const {}: u32 = {from}u;\n", stringify!($field).to_uppercase());
                from += ($length)(shape);
            )*
            text
        }

        /// Number of parameter words of a shape.
        pub(crate) fn word_count(shape: Shape) -> usize {
            0 $(+ ($length)(shape))*
        }
    };
}

pub(crate) use parameters;
