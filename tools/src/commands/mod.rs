//! One file for each command.

pub mod bench;
pub mod choose;
pub mod compare;
pub mod demo;
pub mod displays;
pub mod doctor;
pub mod gaze;
pub mod hardcases;
pub mod info;
pub mod map;
pub mod rates;
pub mod render;
pub mod replay;
pub mod scene;
pub mod sweep;
