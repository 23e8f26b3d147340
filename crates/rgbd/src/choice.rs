//! Which channels of a file are taken, and why.

/// Which channels of a file are taken as what, and why; its text says so in a line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Choice {
    /// The view (eye), where the file has several.
    pub view: Option<String>,
    /// The channels taken as red, green, blue and, where there is one, alpha.
    pub color: Vec<String>,
    /// The channel taken as depth.
    pub depth: Option<String>,
    /// The names of the hidden layers, nearest first.
    pub hidden: Vec<String>,
    /// Whether the file itself says what is what: it is one of ours.
    pub is_stated: bool,
    /// Why, in a sentence.
    pub reason: String,
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "colour from {}", self.color.join(", "))?;
        if let Some(depth) = &self.depth {
            write!(f, "; depth from {depth}")?;
        }
        if !self.hidden.is_empty() {
            write!(f, "; hidden layers {}", self.hidden.join(", "))?;
        }
        if let Some(view) = &self.view {
            write!(f, "; view {view}")?;
        }
        write!(f, " ({})", self.reason)
    }
}
