//! lacuna-grid
