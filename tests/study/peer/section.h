// The section of docs/report.md on other engines, between two markers.
#pragma once

#include <filesystem>
#include <ostream>

#include "tests/study/peer/study.h"

namespace godobject::study {

inline constexpr const char* peers_begin = "<!-- begin of the peers -->\n";
inline constexpr const char* peers_end = "<!-- end of the peers -->\n";

/// Writes the section without the markers. Its first line names the measures in which a peer is better.
void write_peers(std::ostream& out, const PeerResults& results);

/// Replaces the text between the markers of a report. Throws std::runtime_error if it has none, and keeps it.
void replace_peers(const std::filesystem::path& report, const PeerResults& results);

}  // namespace godobject::study
