//! What every method must do on every frame, and known answers of the blur itself.

mod always;
mod answers;
mod bands;
mod energy;
mod fuzz;
mod leak;
mod merged;
mod rays;
mod scenes;
