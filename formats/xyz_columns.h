#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// True if a line's numbers seem to be written with decimal commas: at least three words between
/// blanks or semicolons, all of digits without a point, each with at most one comma, which stands
/// between digits, and one at least with it ("1,5 2,0 3,1", "1,5;2,0;3", but not "1,2,3" or "1, 2,
/// 3").
bool has_decimal_commas(std::string_view line);

/// Which column of a text of coordinates means what; -1: none.
struct XyzColumns {
    std::size_t n_columns = 0;
    int position[3] = {0, 1, 2};
    int normal[3] = {-1, -1, -1};
    int scan = -1;
    std::vector<std::string> names = {};  ///< of all columns, in small
                                          ///< letters, if a line names them

    bool has_normals() const { return normal[0] >= 0; }
    /// Whether the points' positions, normals or scans are in that column.
    bool carries(int column) const {
        bool is_axis = false;
        for (int axis = 0; axis < 3; ++axis)
            is_axis |= position[axis] == column || normal[axis] == column;
        return is_axis || scan == column;
    }
};

/// Columns from a line of names ("x y z nx ny nz", any case, quotes and a leading `//` or `#`
/// allowed). False if the line does not name x, y and z.
bool columns_from_names(std::string_view line, XyzColumns& out);

/// Columns from the first rows, for a file that names none: x y z first; three columns that have
/// unit length in every row (zero, for a point without one, aside) are normals, looked for right
/// behind the coordinates and at the end of the row; all else (intensity, colours) is passed over.
/// rows: at least one, all of n_columns >= 3 numbers
XyzColumns columns_from_rows(const std::vector<std::vector<double>>& rows);

/// Splits at blanks, commas and semicolons.
void split_row(std::string_view line, std::vector<std::string_view>& words);

}  // namespace slim
