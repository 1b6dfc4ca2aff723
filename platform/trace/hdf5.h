// HDF5 files of rows: one data set of doubles for each column. The library is loaded when the first file is
// opened, because the loop's process must not map it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#ifdef GODOBJECT_HDF5  // name of the shared library
#include <dlfcn.h>
#include <hdf5.h>

#include <array>
#endif

namespace godobject {

#ifdef GODOBJECT_HDF5

/// Writer of an HDF5 file. Not for the real-time thread.
class Hdf5Writer {
 public:
  Hdf5Writer() = default;
  ~Hdf5Writer() { static_cast<void>(close()); }
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// Creates a file that does not exist. Returns empty or the error.
  /// about: text of its attribute of this name.
  std::string open(const std::string& path, std::span<const std::string> columns, const std::string& about) {
    if (std::string why_not = load(); !why_not.empty()) return why_not;
    // At the exit the library would write a file again that could not be written, and crash.
    h5_.leave_at_exit();
    if (h5_.open() < 0 || h5_.set_error_printer(H5E_DEFAULT, nullptr, nullptr) < 0)
      return "HDF5 does not start";
    file_ = h5_.create_file(path.c_str(), no_replacement, H5P_DEFAULT, H5P_DEFAULT);
    if (file_ < 0) return "the file cannot be created";
    return add_about(about) && add_columns(columns) ? "" : "HDF5 does not accept the columns";
  }

  /// Adds a row of as many numbers as there are columns.
  void add(std::span<const double> row) {
    for (std::size_t i = 0; i < row.size(); ++i) block_[i * block_rows + in_block_] = row[i];
    if (++in_block_ == block_rows) write_block();
  }

  /// Writes the rest. Returns false if anything was not written.
  [[nodiscard]] bool close() {
    if (file_ < 0) return all_written_;
    write_block();
    for (const hid_t column : columns_) all_written_ = h5_.close_dataset(column) >= 0 && all_written_;
    columns_.clear();
    all_written_ = h5_.close_file(file_) >= 0 && all_written_;
    file_ = -1;
    return all_written_;
  }

 private:
  static constexpr std::size_t block_rows = 4096;
  static constexpr unsigned no_replacement = 4;  // H5F_ACC_EXCL, whose macro calls the library

  /// Used functions and identifiers of the library.
  struct Library {
    decltype(::H5dont_atexit)* leave_at_exit = nullptr;
    decltype(::H5open)* open = nullptr;
    decltype(::H5Eset_auto2)* set_error_printer = nullptr;
    decltype(::H5Fcreate)* create_file = nullptr;
    decltype(::H5Fclose)* close_file = nullptr;
    decltype(::H5Pcreate)* create_properties = nullptr;
    decltype(::H5Pset_chunk)* set_chunk = nullptr;
    decltype(::H5Pset_shuffle)* set_shuffle = nullptr;
    decltype(::H5Pset_deflate)* set_deflate = nullptr;
    decltype(::H5Pclose)* close_properties = nullptr;
    decltype(::H5Screate_simple)* create_space = nullptr;
    decltype(::H5Sselect_hyperslab)* select = nullptr;
    decltype(::H5Sclose)* close_space = nullptr;
    decltype(::H5Dcreate2)* create_dataset = nullptr;
    decltype(::H5Dset_extent)* set_extent = nullptr;
    decltype(::H5Dget_space)* get_space = nullptr;
    decltype(::H5Dwrite)* write = nullptr;
    decltype(::H5Dclose)* close_dataset = nullptr;
    decltype(::H5Tcopy)* copy_type = nullptr;
    decltype(::H5Tset_size)* set_type_size = nullptr;
    decltype(::H5Tclose)* close_type = nullptr;
    decltype(::H5Acreate2)* create_attribute = nullptr;
    decltype(::H5Awrite)* write_attribute = nullptr;
    decltype(::H5Aclose)* close_attribute = nullptr;
    const hid_t *native_double = nullptr, *file_double = nullptr, *text = nullptr,
                *dataset_properties = nullptr;
  };

  std::string load() {
    void* const library = dlopen(GODOBJECT_HDF5, RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr)
      return "the library " GODOBJECT_HDF5 " is missing: install Debian's libhdf5-103-1";
    bool found = true;
    const auto find = [&]<class T>(T*& to, const char* name) {
      to = reinterpret_cast<T*>(dlsym(library, name));
      found = found && to != nullptr;
    };
    find(h5_.leave_at_exit, "H5dont_atexit");
    find(h5_.open, "H5open");
    find(h5_.set_error_printer, "H5Eset_auto2");
    find(h5_.create_file, "H5Fcreate");
    find(h5_.close_file, "H5Fclose");
    find(h5_.create_properties, "H5Pcreate");
    find(h5_.set_chunk, "H5Pset_chunk");
    find(h5_.set_shuffle, "H5Pset_shuffle");
    find(h5_.set_deflate, "H5Pset_deflate");
    find(h5_.close_properties, "H5Pclose");
    find(h5_.create_space, "H5Screate_simple");
    find(h5_.select, "H5Sselect_hyperslab");
    find(h5_.close_space, "H5Sclose");
    find(h5_.create_dataset, "H5Dcreate2");
    find(h5_.set_extent, "H5Dset_extent");
    find(h5_.get_space, "H5Dget_space");
    find(h5_.write, "H5Dwrite");
    find(h5_.close_dataset, "H5Dclose");
    find(h5_.copy_type, "H5Tcopy");
    find(h5_.set_type_size, "H5Tset_size");
    find(h5_.close_type, "H5Tclose");
    find(h5_.create_attribute, "H5Acreate2");
    find(h5_.write_attribute, "H5Awrite");
    find(h5_.close_attribute, "H5Aclose");
    find(h5_.native_double, "H5T_NATIVE_DOUBLE_g");
    find(h5_.file_double, "H5T_IEEE_F64LE_g");
    find(h5_.text, "H5T_C_S1_g");
    find(h5_.dataset_properties, "H5P_CLS_DATASET_CREATE_ID_g");
    return found ? "" : "the library " GODOBJECT_HDF5 " lacks functions of HDF5 1.10";
  }

  bool add_about(const std::string& about) {
    const hid_t space = h5_.create_space(0, nullptr, nullptr), type = h5_.copy_type(*h5_.text);
    h5_.set_type_size(type, about.size());
    const hid_t attribute = h5_.create_attribute(file_, "about", type, space, H5P_DEFAULT, H5P_DEFAULT);
    const bool written = h5_.write_attribute(attribute, type, about.data()) >= 0;
    h5_.close_attribute(attribute);
    h5_.close_type(type);
    h5_.close_space(space);
    return written;
  }

  bool add_columns(std::span<const std::string> columns) {
    constexpr unsigned compression = 1;  // least, because more is hardly smaller
    const hsize_t none = 0, unlimited = H5S_UNLIMITED, chunk = block_rows;
    const hid_t space = h5_.create_space(1, &none, &unlimited),
                properties = h5_.create_properties(*h5_.dataset_properties);
    bool added = h5_.set_chunk(properties, 1, &chunk) >= 0 && h5_.set_shuffle(properties) >= 0 &&
                 h5_.set_deflate(properties, compression) >= 0;
    for (const std::string& column : columns) {
      const hid_t dataset = h5_.create_dataset(file_, column.c_str(), *h5_.file_double, space, H5P_DEFAULT,
                                               properties, H5P_DEFAULT);
      added = added && dataset >= 0;
      if (dataset >= 0) columns_.push_back(dataset);
    }
    h5_.close_properties(properties);
    h5_.close_space(space);
    block_.resize(columns.size() * block_rows);
    return added;
  }

  void write_block() {
    const hsize_t begin = num_rows_, count = in_block_, end = begin + count;
    const hid_t memory = h5_.create_space(1, &count, nullptr);
    for (std::size_t i = 0; i < columns_.size() && count > 0; ++i) {
      bool written = h5_.set_extent(columns_[i], &end) >= 0;
      const hid_t space = h5_.get_space(columns_[i]);
      written = written && h5_.select(space, H5S_SELECT_SET, &begin, nullptr, &count, nullptr) >= 0 &&
                h5_.write(columns_[i], *h5_.native_double, memory, space, H5P_DEFAULT,
                          &block_[i * block_rows]) >= 0;
      h5_.close_space(space);
      all_written_ = all_written_ && written;
    }
    h5_.close_space(memory);
    num_rows_ = end;
    in_block_ = 0;
  }

  Library h5_{};
  hid_t file_ = -1;
  std::vector<hid_t> columns_;
  std::vector<double> block_;  // column by column
  std::size_t in_block_ = 0;   // rows in it
  hsize_t num_rows_ = 0;       // rows before it
  bool all_written_ = true;
};

#else

/// Stands for the writer in a build without HDF5: it opens no file.
class Hdf5Writer {
 public:
  std::string open(const std::string&, std::span<const std::string>, const std::string&) {
    return "this program was built without HDF5: install Debian's libhdf5-dev, and build it again";
  }
  void add(std::span<const double>) {}
  [[nodiscard]] bool close() { return true; }
};

#endif

}  // namespace godobject
