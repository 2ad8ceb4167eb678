//! Macros that declare the tables of a scene file, so that each setting stands in one place.

/// Declares a table of a scene file: the struct, its default values, and its settings, whose descriptions are the doc
/// comments of the fields. A field is `name: type = default => changes, kind, options;`, or `name: type = default;` where it
/// is a table of its own.
macro_rules! settings {
    ($(#[$attribute:meta])* pub struct $table:ident = $prefix:literal { $(
        #[doc = $doc:literal]
        $(#[serde($serde:meta)])?
        $field:ident: $type:ty = $default:expr
            $(=> $changes:ident, $kind:expr $(, $option:ident($($argument:expr),*))*)?;
    )+ }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $table { $(
            #[doc = $doc]
            $(#[serde($serde)])?
            pub $field: $type,
        )+ }

        impl std::default::Default for $table {
            fn default() -> $table {
                $table { $($field: $default),+ }
            }
        }

        impl $table {
            /// The settings of this table.
            pub const SETTINGS: &[$crate::scene::setting::Setting] = {
                use $crate::scene::setting::*;
                &[$($(
                    Setting::new(concat!($prefix, stringify!($field)), $doc, Changes::$changes, $kind)
                        $(.$option($($argument),*))*,
                )?)+]
            };
        }
    };
}

/// Declares the values of a setting: the enum, their names in a scene file, and their descriptions, which are the doc comments
/// of the variants.
macro_rules! choices {
    ($(#[$attribute:meta])* pub enum $enum:ident { $(
        #[doc = $doc:literal]
        $(#[$default:ident])?
        $variant:ident = $name:literal,
    )+ }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $enum { $(
            #[doc = $doc]
            $(#[$default])?
            #[serde(rename = $name)]
            $variant,
        )+ }

        impl $enum {
            /// The name of each value in a scene file, and its description.
            pub const CHOICES: &[(&str, &str)] = &[$(($name, $doc.trim_ascii())),+];

            /// Name in a scene file.
            pub fn name(self) -> &'static str {
                match self { $($enum::$variant => $name),+ }
            }
        }
    };
}

pub(crate) use {choices, settings};
