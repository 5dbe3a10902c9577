//! lacuna-hole
