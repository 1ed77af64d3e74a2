//! intersectors
