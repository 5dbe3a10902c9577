//! lacuna-solve
