//! Input that is cut, absurd or hostile: replayed fuzz corpora, counts beyond memory, limits that hold before allocation.
