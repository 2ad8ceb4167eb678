//! Arguments that are a scene or its variant.

use super::error::VariantError;
use super::scene_variant::Variant;
use crate::scene::Scene;
use crate::shader::Library;
use std::borrow::Cow;

/// A [`Scene`], which is checked where it is used, or its [`Variant`], which is checked already.
pub trait Checkable {
    /// The checked scene.
    ///
    /// # Errors
    /// As [`Variant::of`].
    fn checked(&self, library: &Library) -> Result<Cow<'_, Variant>, VariantError>;

    /// The checked scene, after an earlier one that [`Variant::after`] may use.
    ///
    /// # Errors
    /// As [`Variant::of`].
    fn checked_after<'a>(
        &'a self,
        library: &Library,
        last: Option<&'a Variant>,
    ) -> Result<Cow<'a, Variant>, VariantError>;
}

impl Checkable for Scene {
    fn checked(&self, library: &Library) -> Result<Cow<'_, Variant>, VariantError> {
        Variant::of(self, library).map(Cow::Owned)
    }

    fn checked_after<'a>(
        &'a self,
        library: &Library,
        last: Option<&'a Variant>,
    ) -> Result<Cow<'a, Variant>, VariantError> {
        last.map_or_else(|| self.checked(library), |last| last.after(self, library))
    }
}

impl Checkable for Variant {
    fn checked(&self, _: &Library) -> Result<Cow<'_, Variant>, VariantError> {
        Ok(Cow::Borrowed(self))
    }

    fn checked_after<'a>(&'a self, _: &Library, _: Option<&'a Variant>) -> Result<Cow<'a, Variant>, VariantError> {
        Ok(Cow::Borrowed(self))
    }
}
