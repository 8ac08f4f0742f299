#include "formats/slice_file.h"

#include "formats/message.h"
#include "formats/slice_kind.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <xxhash.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iomanip>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace slim {
namespace {

std::string columns_text(bool has_normals, bool has_scans) {
    return message(has_normals ? "normals" : "no normals", " and ",
                   has_scans ? "scans" : "no scans");
}

std::string origin_text(const Vec3d& o) {
    return message(std::setprecision(15), "(", o.x, ", ", o.y, ", ", o.z, ")");
}

/// An open slice and what its pieces are.
class SliceReader {
public:
    explicit SliceReader(const std::string& path) : file_(ChunkFile::open(path, kSliceKind)) {
        if (file_.version() < kSliceKind.version)
            throw FormatError(message(path, ": byte 8: SLIM slice version ", file_.version(),
                                      ", of an earlier slim; expected ", kSliceKind.version,
                                      ": run `slim slice` or `slim build` again"));
        for (const char* chunk : {"origin", "columns", "pieces"}) file_.verify(chunk);
        columns_ = one<SliceColumns>("columns");
        pieces_ = file_.array<SlicePiece>("pieces");
        check_pieces();
    }

    Vec3d origin() const { return one<Vec3d>("origin"); }
    bool has_normals() const { return columns_.has_normals != 0; }
    bool has_scans() const { return columns_.has_scans != 0; }
    std::span<const SlicePiece> pieces() const { return pieces_; }
    std::string columns_text() const { return slim::columns_text(has_normals(), has_scans()); }
    [[noreturn]] void fail_at(const char* chunk, const std::string& text) const {
        throw FormatError(message(file_.path(), ": byte ", file_.offset(chunk), ": ", text));
    }

    /// Reads a piece against its checksum and calls body(columns). Thread-safe.
    template <class Body>
    void with_piece(std::size_t i, const Body& body) const {
        const SlicePiece& piece = pieces_[i];
        thread_local std::vector<unsigned char> bytes;
        bytes.resize(size_of(piece));
        file_.read("points", piece.first_byte, bytes);
        if (XXH3_64bits(bytes.data(), bytes.size()) != piece.checksum)
            fail(piece, message("damaged: piece ", i, " of the points (", piece.n_points,
                                " of them) does not match its checksum", advice()));
        body(PieceColumns(piece, bytes, has_normals(), has_scans()));
    }

private:
    template <class T>
    T one(const char* chunk) const {
        const std::span<const T> values = file_.array<T>(chunk);
        if (values.size() != 1)
            throw FormatError(message(file_.path(), ": byte ", file_.offset(chunk), ": chunk ",
                                      chunk, ": expected 1 entry, found ", values.size()));
        return values[0];
    }
    std::uint64_t size_of(const SlicePiece& piece) const {
        return piece.n_bytes(has_normals(), has_scans());
    }
    [[noreturn]] void fail(const SlicePiece& piece, const std::string& text) const {
        throw FormatError(message(file_.path(), ": byte ",
                                  file_.offset("points") + piece.first_byte, ": ", text));
    }
    /// How a damaged file of a work folder is made again: the stage that wrote it looks at its
    /// checksums.
    const char* advice() const {
        return file_.path().ends_with("oriented.slice") ? "; run `slim normals` again"
               : file_.path().ends_with("points.slice") ? "; run `slim slice` again"
                                                        : "";
    }
    /// A piece that does not begin where the one before ends, or is not of what pieces are made of.
    void check_piece(std::size_t i, std::uint64_t at, std::uint64_t end) const {
        const SlicePiece& p = pieces_[i];
        const auto require = [&](bool holds, std::size_t field, const auto&... words) {
            if (!holds)
                throw FormatError(message(file_.path(), ": byte ",
                                          file_.offset("pieces") + i * sizeof(SlicePiece) + field,
                                          ": chunk pieces: piece ", i, ": ", words...));
        };
        const auto is_width = [](std::uint16_t bytes) { return bytes == 4 || bytes == 8; };
        require(p.first_byte == at, offsetof(SlicePiece, first_byte), "expected the first byte ",
                at, ", where the piece before it ends, found ", p.first_byte);
        require(is_width(p.coordinate_bytes), offsetof(SlicePiece, coordinate_bytes),
                "expected coordinates of 4 or 8 bytes, found ", p.coordinate_bytes);
        require(is_width(p.id_bytes), offsetof(SlicePiece, id_bytes),
                "expected ids of 4 or 8 bytes, found ", p.id_bytes);
        require(p.n_points > 0, offsetof(SlicePiece, n_points),
                "expected at least one point, found 0");
        require(size_of(p) <= end - at, offsetof(SlicePiece, n_points),
                "expected points of at most ", end - at,
                " bytes, as many as chunk points has left, found ", p.n_points, " points of ",
                size_of(p), " bytes");
    }
    void check_pieces() const {
        std::uint64_t at = 0;
        const std::uint64_t end = file_.n_bytes("points");
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            check_piece(i, at, end);
            at += size_of(pieces_[i]);
        }
        if (at != end)
            throw FormatError(message(file_.path(), ": byte ", file_.offset("points"),
                                      ": chunk points: expected ", at, " bytes, found ", end));
    }

    ChunkFile file_;
    SliceColumns columns_{};
    std::span<const SlicePiece> pieces_;
};

/// Room for so many points in all, and no more; the first to touch a page pays for it.
void resize_exactly(std::size_t n, bool has_normals, bool has_scans, PointBlock& out) {
    const auto resize = [n](auto& values) {
        values.reserve(n);
        values.resize(n);
    };
    run_both([&] { resize(out.position); }, [&] {
        resize(out.id);
        if (has_normals) resize(out.normal);
        if (has_scans) resize(out.scan);
    });
}

/// Copies all of a block to the places from `at` on of one that has room for it.
void copy_columns(const PointBlock& from, PointBlock& out, std::size_t at) {
    const auto copy = [at](const auto& values, auto& to) {
        std::copy(values.begin(), values.end(), to.begin() + static_cast<std::ptrdiff_t>(at));
    };
    copy(from.position, out.position);
    copy(from.id, out.id);
    copy(from.normal, out.normal);
    copy(from.scan, out.scan);
}

}  // namespace

/// A slice, and what to take of each of its pieces.
struct SliceSelection::Part {
    std::string path;
    SliceReader slice;
    std::vector<std::size_t> taken;          // of every piece, how many points
    std::vector<std::vector<bool>> chosen;   // which; empty: all or none of them, or kept
    std::vector<PointBlock> kept;            // a few of a piece
    std::size_t n = 0;

    explicit Part(const std::string& of_slice)
        : path(of_slice),
          slice(of_slice),
          taken(slice.pieces().size()),
          chosen(taken.size()),
          kept(taken.size()) {}

    /// choose(columns, i) says which points are wanted where a box does not. A piece of which few
    /// are is read once: these are kept. More would fill the heaps of all threads.
    template <class Choose>
    void take(const std::function<WantedOf(const Bbox&)>& wanted_of, const Choose& choose) {
        parallel_blocks(taken.size(), 1, [&](std::size_t i, std::size_t) {
            const SlicePiece& piece = slice.pieces()[i];
            const WantedOf wanted = wanted_of(piece.box);
            if (wanted == WantedOf::all) taken[i] = piece.n_points;
            if (wanted == WantedOf::some)
                slice.with_piece(i, [&](const PieceColumns& columns) { keep(i, columns, choose); });
        });
        for (const std::size_t of_piece : taken) n += of_piece;
    }
    void copy_to(PointBlock& out, std::size_t begin) const {
        std::vector<std::size_t> at(taken.size(), begin);
        for (std::size_t i = 1; i < at.size(); ++i) at[i] = at[i - 1] + taken[i - 1];
        parallel_blocks(taken.size(), 1, [&](std::size_t i, std::size_t) {
            if (taken[i] == 0) return;
            if (!kept[i].empty()) return copy_columns(kept[i], out, at[i]);
            slice.with_piece(i, [&](const PieceColumns& columns) {
                columns.copy_to(chosen[i], out, at[i]);
            });
        });
    }

private:
    /// By one thread: while it waited for others it might read another piece into the same bytes.
    template <class Choose>
    void keep(std::size_t i, const PieceColumns& columns, const Choose& choose) {
        constexpr std::size_t kFew = 4;  // one in so many
        const std::size_t n_here = slice.pieces()[i].n_points;
        std::vector<std::uint32_t> wanted(n_here);
        std::size_t n_wanted = 0;
        for (std::size_t k = 0; k < n_here; ++k) {
            wanted[n_wanted] = static_cast<std::uint32_t>(k);
            n_wanted += choose(columns, k) ? 1 : 0;
        }
        wanted.resize(n_wanted);
        taken[i] = n_wanted;
        if (n_wanted == 0 || n_wanted == n_here) return;
        if (kFew * n_wanted > n_here) {
            chosen[i].assign(n_here, false);
            for (const std::uint32_t k : wanted) chosen[i][k] = true;
            return;
        }
        PointBlock& to = kept[i];
        to.position.resize(n_wanted);
        to.id.resize(n_wanted);
        if (slice.has_normals()) to.normal.resize(n_wanted);
        if (slice.has_scans()) to.scan.resize(n_wanted);
        columns.copy_to(std::span<const std::uint32_t>(wanted), to, 0);
    }
};

SliceSelection::SliceSelection() = default;
SliceSelection::~SliceSelection() = default;

void SliceSelection::add(const std::string& path,
                         const std::function<WantedOf(const Bbox&)>& wanted_of,
                         const std::function<bool(const Vec3d&)>& is_wanted) {
    auto part = std::make_unique<Part>(path);
    part->take(wanted_of, [&](const PieceColumns& columns, std::size_t k) {
        return is_wanted(columns.position(k));
    });
    if (part->n > 0 || parts_.empty()) parts_.push_back(std::move(part));
}

void SliceSelection::add(const std::string& path) {
    add(path, [](const Bbox&) { return WantedOf::all; }, [](const Vec3d&) { return true; });
}

void SliceSelection::add(const std::string& path,
                         const std::function<bool(std::uint64_t id)>& is_wanted) {
    auto part = std::make_unique<Part>(path);
    part->take([](const Bbox&) { return WantedOf::some; },
               [&](const PieceColumns& columns, std::size_t k) {
                   return is_wanted(columns.id(k));
               });
    if (part->n > 0 || parts_.empty()) parts_.push_back(std::move(part));
}

void SliceSelection::append_to(PointBlock& out) const {
    if (parts_.empty()) return;
    const SliceReader& first = parts_[0]->slice;
    const bool was_empty = out.empty();
    const bool has_normals = was_empty ? first.has_normals() : out.has_normals();
    const bool has_scans = was_empty ? first.has_scans() : out.has_scans();
    const std::string as =
        was_empty ? ", as in " + parts_[0]->path : ", as of the points that it is added to";
    if (was_empty) out.origin = first.origin();
    std::size_t n = out.size();
    for (const auto& part : parts_) {
        n += part->n;
        if (part->n == 0) continue;
        const SliceReader& slice = part->slice;
        if (slice.has_normals() != has_normals || slice.has_scans() != has_scans)
            slice.fail_at(
                "columns",
                message("has other columns than the slice that it is joined with: expected ",
                        columns_text(has_normals, has_scans), as, ", found ",
                        slice.columns_text()));
        if (slice.origin() != out.origin)
            slice.fail_at(
                "origin",
                message("has another origin than the slice that it is joined with: expected ",
                        origin_text(out.origin), as, ", found ", origin_text(slice.origin())));
    }
    std::size_t at = out.size();
    resize_exactly(n, has_normals, has_scans, out);
    for (const auto& part : parts_) {
        part->copy_to(out, at);
        at += part->n;
    }
}

bool is_slice_file(const std::string& path) {
    char magic[8] = {};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return std::string_view(magic, sizeof magic) == kSliceKind.magic;
}

std::string slice_identity(const std::string& path) {
    return ChunkFile::open(path, kSliceKind).identity();
}

bool is_whole_slice(const std::string& path, const std::string& identity) {
    try {
        const ChunkFile file = ChunkFile::open(path, kSliceKind);
        if (file.identity() != identity) return false;
        for (const char* chunk : {"origin", "columns", "pieces"}) file.verify(chunk);
        file.for_pieces<unsigned char>("points", [](std::size_t, auto) {});
        return true;
    } catch (const Error&) {
        return false;
    }
}

PointBlock read_slice(const std::string& path) {
    SliceSelection all;
    all.add(path);
    PointBlock block;
    all.append_to(block);
    return block;
}

}  // namespace slim
