//! The numbers that Miller and Jones 2005 print, in frames per second.
//!
//! Columns of Tables 1 and 2 are the windows of the replay. The paper prints neither the object, nor the number of
//! slices, nor the format that they are blended in, nor any error.

/// The cards of Tables 1 and 2.
pub(crate) const CARDS: [&str; 2] = ["9700 Pro", "6800 GT"];

/// One row of Tables 1 and 2: our preset, what the paper calls it, and what the two cards do.
pub const EFFECTS: [(&str, &str, [[f64; 4]; 2]); 6] = [
    ("lit", "Lit rendering", [[29.82, 21.25, 5.64, 5.01], [72.49, 46.11, 20.57, 11.63]]),
    ("solid", "Solid texturing", [[23.21, 17.00, 4.30, 4.26], [69.33, 45.09, 20.02, 11.34]]),
    ("bump", "Bump mapping", [[25.26, 21.25, 4.91, 4.72], [64.21, 41.27, 17.52, 9.69]]),
    ("fur", "Fur", [[17.10, 14.17, 3.43, 3.27], [39.52, 24.32, 9.88, 5.43]]),
    ("melting", "Melting", [[15.78, 10.63, 4.02, 3.70], [57.36, 38.26, 16.92, 9.71]]),
    ("fire", "Fire", [[23.24, 17.00, 4.18, 4.05], [46.30, 27.04, 10.42, 5.64]]),
];

/// Seconds that Satherley and Jones 2002 took in software for a picture of 300 x 300 (MJ 3).
pub(crate) const SOFTWARE_SECONDS: f64 = 50.0;
/// Frames per second on a full screen, 1024 x 768, by the paper's conclusion (MJ 7).
pub(crate) const FULL_SCREEN: f64 = 10.0;
/// Side of the block of noise that had the best balance of speed and resolution (MJ 7), texels.
pub(crate) const BEST_BLOCK: u32 = 64;
/// How much slower than the 9700 Pro the FX 5900 is, about (MJ 7).
pub(crate) const FX_5900: f64 = 2.0;
