#pragma once

#include "formats/chunk_file.h"
#include "slim/model/fitted_surfel.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What a fit leaves for the tree: surfels in its own order, and a JSON text about the fit as a
/// whole (the library does not look into it).
struct FitFile {
    std::string header_json;
    std::vector<FittedSurfel> surfels;
    /// ids of points that belong to no surfel, for the fits after this one
    std::vector<std::uint64_t> dropped;
};

/// Writes a fit whose surfels come one by one and need not stay in memory. Without commit() no file
/// is left. Throws as AtomicFile.
class FitWriter {
public:
    explicit FitWriter(const std::string& path);
    ~FitWriter();
    FitWriter(const FitWriter&) = delete;
    FitWriter& operator=(const FitWriter&) = delete;

    void add(const FittedSurfel& surfel);
    void commit(const std::string& header_json, std::span<const std::uint64_t> dropped = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Throws as AtomicFile.
void write_fit(const std::string& path, std::span<const FittedSurfel> surfels,
               const std::string& header_json, std::span<const std::uint64_t> dropped = {});

/// A fit whose surfels pass one by one: for fits larger than memory. Stays the file that was
/// opened, should another one take its name meanwhile.
class FitReader {
public:
    /// throws FormatError naming file, place and reason; IoError
    explicit FitReader(const std::string& path);

    const std::string& header_json() const { return header_json_; }
    std::size_t n_surfels() const;
    /// Calls visit for every surfel in the file's order, as often as this is called; leaves no page
    /// of them mapped. A surfel is seen before the checksum of all is: the end of the call tells.
    /// throws FormatError
    void for_each(const std::function<void(FittedSurfel&&)>& visit) const;
    std::vector<std::uint64_t> dropped() const;

private:
    ChunkFile file_;
    std::string header_json_;
};

/// The surfels that are wanted (all if that is empty); takes no memory but theirs.
/// throws as FitReader
FitFile read_fit(const std::string& path,
                 const std::function<bool(const FittedSurfel&)>& is_wanted = {});

}  // namespace slim
