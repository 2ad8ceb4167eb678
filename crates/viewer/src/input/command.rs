//! Commands of the user.

use crate::playback::Playback;
use std::path::PathBuf;

/// A command of the user: of a key, a menu, a control or a dropped file. One without a value switches a state on or
/// off, or does what its key is described to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Begins a new scene, after a question if this one is not saved.
    New,
    /// Begins a new scene.
    Begin,
    /// Opens the file dialog.
    ChooseFile,
    /// Opens a mesh, a scan, a scene or a module.
    Open(PathBuf),
    /// Saves the scene to its file.
    Save,
    /// Saves the scene to a file.
    SaveTo(PathBuf),
    /// Opens the file dialog for the name of the scene file.
    SaveAs,
    /// Restores the unsaved work in a folder.
    Restore(PathBuf),
    /// Shows or hides the dialog for final pictures.
    Export,
    /// Looks at the print that was written last, after a question if the scene is not saved.
    AskToLook,
    /// Looks at the print that was written last, in a new scene.
    Look,
    /// Closes the program, after a question if work is unsaved.
    AskToQuit,
    /// Closes the program.
    Quit,
    /// Undoes the last step.
    Undo,
    /// Repeats the last undone step.
    Redo,
    /// Takes a preset.
    Preset {
        /// Name of the preset.
        name: String,
        /// Whether object and view stay.
        on_object: bool,
    },
    /// Takes the previous preset.
    PreviousPreset,
    /// Takes the next preset.
    NextPreset,
    /// Adds an object.
    AddPart,
    /// Removes an additional object.
    RemovePart(String),
    /// Renames an additional object.
    RenamePart {
        /// The present name.
        from: String,
        /// The new name.
        to: String,
    },
    /// Duplicates the selected object.
    Duplicate,
    /// Removes the selected keyframe, else the selected object.
    Delete,
    /// Starts or ends the placement of the selected object or the light.
    Place,
    /// Turns the brush on or off.
    Paint,
    /// Weakens the brush.
    WeakerBrush,
    /// Strengthens the brush.
    StrongerBrush,
    /// Frames the selected object, or all.
    Frame,
    /// Resets the camera to that of the preset.
    ResetCamera,
    /// Looks from a side, by its index in the list of sides.
    Side(usize),
    /// Switches between a level orbit and a trackball.
    LevelOrbit,
    /// Switches the inertia of the trackball.
    Inertia,
    /// Shows or hides the panels.
    Panels,
    /// Moves the focus to the controls.
    FocusControls,
    /// Enters or leaves the full screen.
    FullScreen,
    /// Plays or pauses.
    Play,
    /// Sets the time, seconds.
    Time(f64),
    /// Sets speed, range and repetition of time.
    Playback(Playback),
    /// Writes the current picture to a new file.
    WritePicture,
    /// Writes the current picture to a file.
    Screenshot(PathBuf),
    /// Writes the pictures of a turntable, or stops.
    Turntable,
    /// Pins this variant and compares with it, or stops.
    Compare,
    /// Shows the next display of a comparison.
    NextComparison,
    /// Inspects the pixel under the pointer, or stops.
    InspectPixel,
    /// Inspects the next of the worst pixels.
    WorstPixel,
    /// Shows or hides the validity of pixels.
    Validity,
    /// Sets the error target; `None` uses the samples of the scene.
    MaxError(Option<f64>),
    /// Computes the histogram of densities for the transfer map.
    Densities,
    /// Shows or hides the list of keys.
    Help,
    /// Shows or hides the lesson.
    Lesson,
    /// Ends the innermost mode, at last the window.
    Leave,
}
