//! lacuna-system
