//! The object of the frames of a moving scene.

use hypertexture::render::variant::Variant;
use hypertexture::render::{RenderError, Subject, SubjectRequest};
use hypertexture::shader::Library;

/// The object of a frame; another frame may need another field of it.
pub(crate) struct FrameObject {
    pub(crate) subject: Subject,
    wanted: Vec<SubjectRequest>,
}

impl FrameObject {
    /// The object loaded for a scene.
    pub(crate) fn of(variant: &Variant, subject: &Subject) -> FrameObject {
        FrameObject { subject: subject.clone(), wanted: SubjectRequest::all(variant) }
    }

    /// Loads the object for a frame, unless the present one serves it. Returns whether it is another.
    pub(crate) fn serve(&mut self, frame: &Variant, library: &Library) -> Result<bool, RenderError> {
        let wanted = SubjectRequest::all(frame);
        let is_other = wanted != self.wanted;
        if is_other {
            *self = FrameObject { subject: Subject::load(frame, library, &|_| ())?, wanted };
        }
        Ok(is_other)
    }
}
