//! Macros that declare the tables of a scene file, so that each setting stands in one place.

/// Declares a table of a scene file: the struct, its default values, the identities of its fields, and its settings, whose
/// descriptions are the doc comments of the fields. A field is `name: type = default => changes, kind, options;`, or
/// `name: type = default;` for a field that is not a setting, such as a table.
macro_rules! settings {
    ($(#[$attribute:meta])* pub struct $table:ident: $id:ident = $prefix:literal { $(
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

        #[doc = concat!("Identity of a field of [`", stringify!($table), "`], with that of a field below it.")]
        #[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[allow(non_camel_case_types, reason = "the names are those of the fields")]
        pub enum $id { $(
            #[doc = $doc]
            $field(<$type as $crate::scene::fields::setting::Node>::Id),
        )+ }

        const _: () = {
            use $crate::scene::fields::setting::*;
            use toml::Value;

            /// The setting of each field that is one.
            struct Own { $($field: Option<Setting>),+ }

            const OWN: Own = Own { $($field: only(&[$(
                Setting::new(concat!($prefix, stringify!($field)), $doc, Changes::$changes, $kind)
                    $(.$option($($argument),*))*
            )?])),+ };

            static TABLE: Own = OWN;

            impl $table {
                /// The settings of this table.
                pub const SETTINGS: &[Setting] = &[$($(of(OWN.$field, Changes::$changes),)?)+];
            }

            impl Node for $table {
                type Id = $id;

                fn find(name: &str) -> Option<$id> {
                    let (own, below) = name.split_once('.').unwrap_or((name, ""));
                    match own {
                        $(stringify!($field) => <$type as Node>::find(below).map($id::$field),)+
                        _ => None,
                    }
                }

                fn write_name(id: &$id, name: &mut String) {
                    match id { $(
                        $id::$field(below) => {
                            push_name(name, stringify!($field));
                            <$type as Node>::write_name(below, name);
                        }
                    )+ }
                }

                fn setting(id: &$id) -> Option<&'static Setting> {
                    match id { $(
                        $id::$field(below) => TABLE.$field.as_ref().or_else(|| <$type as Node>::setting(below)),
                    )+ }
                }

                fn each(&self, on: &mut dyn FnMut($id)) {
                    $(<$type as Node>::each(&self.$field, &mut |below| on($id::$field(below)));)+
                }

                fn get(&self, id: &$id) -> Option<Value> {
                    match id { $($id::$field(below) => <$type as Node>::get(&self.$field, below),)+ }
                }

                fn set(&mut self, id: &$id, value: Option<&Value>, _: fn() -> $table) -> Result<(), toml::de::Error> {
                    match id { $(
                        $id::$field(below) => <$type as Node>::set(&mut self.$field, below, value, || $default),
                    )+ }
                }

                fn animate(&mut self, id: &$id, moment: Moment<'_>, _: Option<&Setting>) -> bool {
                    match id { $(
                        $id::$field(below) => {
                            <$type as Node>::animate(&mut self.$field, below, moment, TABLE.$field.as_ref())
                        }
                    )+ }
                }

                fn changes(&self, other: &$table, _: Option<&Setting>) -> ChangeSet {
                    ChangeSet::default()
                        $(.with(<$type as Node>::changes(&self.$field, &other.$field, TABLE.$field.as_ref())))+
                }

                fn is_valid(&self, _: Option<&Setting>) -> bool {
                    true $(&& <$type as Node>::is_valid(&self.$field, TABLE.$field.as_ref()))+
                }
            }
        };
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

        impl $crate::scene::fields::setting::Leaf for $enum {}
    };
}

pub(crate) use {choices, settings};
