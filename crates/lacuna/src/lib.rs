//! lacuna
