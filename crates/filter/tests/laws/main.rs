//! What every method must do on every frame, and known answers of the blur itself.

mod always;
mod anamorphic;
mod answers;
mod bands;
mod cat_eye;
mod energy;
mod fuzz;
mod highlights;
mod images;
mod leak;
mod merged;
mod predicted;
mod rays;
mod scenes;
