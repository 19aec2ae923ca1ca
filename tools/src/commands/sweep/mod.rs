//! `macula sweep`: what accuracy costs in time.
#![allow(dead_code)]

pub mod front;
pub mod record;
pub mod report;
