//! bhs
