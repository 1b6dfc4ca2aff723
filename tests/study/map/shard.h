// Result files of the stability map: shards of a run, their continuation after a kill, and their union.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/study/map/sample.h"

namespace godobject::study {

/// Part k of n of a run, from 1: the samples whose number is k - 1 modulo n.
struct Shard {
  std::uint64_t k = 1, n = 1;

  bool operator==(const Shard&) const = default;
  std::uint64_t size(std::uint64_t samples) const { return samples < k ? 0 : (samples - k) / n + 1; }
  std::uint64_t number(std::uint64_t row) const { return k - 1 + row * n; }
};

/// Parses "k/n", 1 <= k <= n. Throws std::runtime_error.
Shard parse_shard(const std::string& text);

/// Head of a file: everything that its rows depend on.
struct MapHead {
  std::uint64_t seed = 0, samples = 0;
  Shard shard;
  // of results that this program computes on this machine: another program, compiler or processor that
  // computes other bits has another one
  std::string fingerprint;

  bool operator==(const MapHead&) const = default;
  /// Returns the first two lines of the file: head and names of columns.
  std::string lines() const;
};

/// Returns the row of a sample, without the end of line.
std::string row_of(const MapSample& sample);
/// Reads a row. Throws std::runtime_error if it has not the fields of row_of().
MapSample parse_row(const std::string& line);
/// Returns the names of the columns.
std::string map_columns();

/// Hashes the rows of the first scenes of all families with seed 0.
std::string map_fingerprint();

/// A file as it is on disk, its last line left out if it is torn.
struct MapFile {
  MapHead head;
  std::vector<std::string> rows;
  std::uintmax_t whole_bytes = 0;  // up to the end of the last whole line; 0: no whole head
};

/// Reads a file. Throws std::runtime_error, which names file and line, if it is no result of a stability map.
/// The same if its rows are not the first ones of its shard.
MapFile read_map(const std::filesystem::path& file);

/// True if the file begins with this head: it is of the same run, which run_shard() continues.
bool begins_with(const MapHead& head, const std::filesystem::path& file);

/// rows done, rows in all
using MapProgress = std::function<void(std::uint64_t, std::uint64_t)>;

/// Runs a shard and writes each row as soon as it is computed. An interrupted file of the same run is
/// continued. Throws std::runtime_error if the file belongs to another run or cannot be written.
void run_shard(const MapHead& head, const std::filesystem::path& file, const MapProgress& progress);

/// Writes the union of the shards, which is the file that one run would have written. Throws
/// std::runtime_error, which names the file, for shards that overlap, are missing or are incomplete. The same
/// for another seed, number of samples, division or program.
void merge_shards(const std::vector<std::filesystem::path>& files, const std::filesystem::path& out);

}  // namespace godobject::study
