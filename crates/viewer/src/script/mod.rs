//! Scripts of user input, for tests and screenshots.
//!
//! A script has one step per line; `#` starts a comment. Each step ends before the next one starts:
//! ```text
//! wait picture | converged         until the scene's own picture is shown, or a converged one
//! wait validity                    until the validity of the pixels is shown
//! wait inspected                   until the report on the inspected pixel is complete
//! wait drawn                       until any picture of the current scene is shown
//! wait loading                     until an object is being loaded
//! frames N                         until N frames were drawn
//! size W H                         resizes the window, points
//! minimize, restore                minimizes or restores the window
//! key NAME                         presses a key, named as in the help
//! type TEXT                        types text
//! drag X Y X Y [right | ctrl]      drags over the picture, in fractions from its left and top
//! scroll LINES                     turns the wheel in the center of the picture
//! orbit MOVES SECONDS              drags in circles, and prints the latency of the window
//! wait idle                        until no task is running
//! click NAME                       clicks the last control of that name
//! where NAME                       prints the rectangle of a control, by its name or the beginning of it
//! set NAME NUMBER                  sets a slider
//! write NAME TEXT                  replaces the text of a field, `\n` for a new line
//! wait good | bad                  until the text of the editor has passed, or was refused
//! copy FILE FILE                   copies a file, as another program would
//! drop FILE                        drops a file on the window
//! shot FILE                        writes the picture of the scene
//! lose                             simulates a lost device
//! panic                            simulates a fault of the program
//! quit                             closes the window
//! ```

mod input_latency;
mod parse;
mod run;
mod widgets;

pub(crate) use parse::ScriptEvent;
pub(crate) use run::Script;
pub(crate) use widgets::{Widget, widgets};
