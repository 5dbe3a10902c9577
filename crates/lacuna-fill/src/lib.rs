//! lacuna-fill
