#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  ///< of UTF-8

/// Bytes of a file from front to back through one buffer; a gzip file is unpacked on the way.
///
/// throws IoError if the file cannot be opened or read, FormatError if its gzip stream is damaged
///        or a line is longer than 16 MiB
/// cost   a buffer of 1 MiB, more only for a longer line or peek
class ByteReader {
public:
    explicit ByteReader(const std::string& path);
    ~ByteReader();
    ByteReader(const ByteReader&) = delete;
    ByteReader& operator=(const ByteReader&) = delete;

    /// What is buffered: at least `wanted` bytes, fewer only at the end of the file.
    std::string_view peek(std::size_t wanted);
    /// Drops n bytes that peek() showed.
    void advance(std::size_t n) { begin_ += n; }
    /// Passes over n bytes; false if the file ends before.
    bool skip(std::uint64_t n);
    /// Drops UTF-8's byte order mark (EF BB BF) if that comes next, as at the start of a text saved
    /// on Windows; says whether.
    bool skip_byte_order_mark();
    /// The next line without its end (LF, CR LF, or CR in a file that has only these); false at the
    /// end of the file. The view lives until the next call.
    bool read_line(std::string_view& line);

    const std::string& path() const { return path_; }
    bool is_gzip() const { return inflater_ != nullptr; }
    std::uint64_t file_size() const { return file_size_; }
    /// Bytes of the file on disk that were taken in so far; for progress.
    std::uint64_t file_bytes_read() const { return file_offset_; }
    /// Place of the next byte in the unpacked stream.
    std::uint64_t offset() const { return base_ + begin_; }
    /// Number of the line that read_line() gave last, from 1.
    std::uint64_t line_number() const { return line_number_; }
    /// Bytes still to come; nothing for a gzip file, whose length is known only at its end.
    std::optional<std::uint64_t> remaining() const;

private:
    struct Inflater;

    bool refill();
    std::size_t read_file(char* out, std::size_t n);
    std::size_t inflate_some(char* out, std::size_t n);
    void find_line_end();

    std::string path_;
    int file_ = -1;
    std::uint64_t file_size_ = 0;
    std::uint64_t file_offset_ = 0;
    std::unique_ptr<Inflater> inflater_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0;   ///< first byte not yet taken
    std::size_t end_ = 0;     ///< end of the valid bytes
    std::uint64_t base_ = 0;  ///< stream offset of buffer_[0]
    std::uint64_t line_number_ = 0;
    char line_end_ = '\n';
};

}  // namespace slim
