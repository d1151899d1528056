//! A value that may be written in two ways.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{self, Deserialize, Deserializer, IntoDeserializer, MapAccess, SeqAccess, Visitor};

use crate::key::scalar::Scalar;

/// One value, or a table or list of the form `T`.
#[derive(Debug)]
pub(crate) enum Either<T> {
    One(Scalar),
    Other(T),
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Either<T> {
    /// By hand, as serde's untagged enums lose the places of values.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Either<T>, D::Error> {
        struct OneOrOther<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrOther<T> {
            type Value = Either<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("one value, a list or a table")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Either<T>, E> {
                Scalar::deserialize(text.into_deserializer()).map(Either::One)
            }

            fn visit_i64<E: de::Error>(self, i: i64) -> Result<Either<T>, E> {
                Scalar::deserialize(i.into_deserializer()).map(Either::One)
            }

            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Either<T>, E> {
                Scalar::deserialize(x.into_deserializer()).map(Either::One)
            }

            fn visit_bool<E: de::Error>(self, b: bool) -> Result<Either<T>, E> {
                Scalar::deserialize(b.into_deserializer()).map(Either::One)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Either<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Either::Other)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Either<T>, A::Error> {
                T::deserialize(SeqAccessDeserializer::new(seq)).map(Either::Other)
            }
        }

        deserializer.deserialize_any(OneOrOther(PhantomData))
    }
}

impl<T: JsonSchema> JsonSchema for Either<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("OneOr{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let other = generator.subschema_for::<T>();
        schemars::json_schema!({ "anyOf": [{ "type": "string" }, other] })
    }
}
