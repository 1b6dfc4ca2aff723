#include "sim/node/canopen/sdo_server.h"

namespace godobject {

using sdo::AbortCode;
using sdo::Message;
using sdo::Request;
using sdo::Response;

std::optional<Message> SdoServer::answer(const Message& request) noexcept {
  switch (static_cast<Request>(sdo::command_of(request))) {
    case Request::initiate_download: address_ = sdo::address_of(request); return initiate_download(request);
    case Request::initiate_upload: address_ = sdo::address_of(request); return initiate_upload();
    case Request::download_segment: return download_segment(request);
    case Request::upload_segment: return upload_segment(request);
    case Request::abort: reset(); return std::nullopt;
  }
  address_ = sdo::address_of(request);
  return abort(AbortCode::unknown_command);  // block transfer
}

Message SdoServer::initiate_download(const Message& request) noexcept {
  reset();
  const sdo::Initiation initiation = sdo::initiation_of(request);
  if (initiation.expedited) {
    std::span<const std::uint8_t> bytes = sdo::expedited_data(request);
    const Object* object = objects_.find(address_);
    // without a size, that of the object is used
    if (!initiation.size_given && object != nullptr)
      bytes = bytes.first(std::min(bytes.size(), canopen::size_of(object->type)));
    const AbortCode code = objects_.write(address_, bytes);
    return code == AbortCode::none ? sdo::make_plain(Response::initiate_download, address_) : abort(code);
  }
  if (initiation.size_given && initiation.size > capacity) return abort(AbortCode::out_of_memory);
  announced_ = initiation;
  size_ = 0;
  toggle_ = false;
  transfer_ = Transfer::download;
  return sdo::make_plain(Response::initiate_download, address_);
}

Message SdoServer::download_segment(const Message& request) noexcept {
  if (transfer_ != Transfer::download) return abort(AbortCode::unknown_command);
  if (sdo::toggle_of(request) != toggle_) return abort(AbortCode::toggle_not_alternated);
  const std::span<const std::uint8_t> bytes = sdo::segment_data(request);
  if (bytes.size() > capacity - size_) return abort(AbortCode::out_of_memory);
  std::ranges::copy(bytes, data_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
  if (sdo::is_last_segment(request)) {
    if (announced_.size_given && announced_.size != size_) return abort(AbortCode::wrong_length);
    const AbortCode code = objects_.write(address_, std::span(data_).first(size_));
    if (code != AbortCode::none) return abort(code);
    reset();
  }
  const Message turn = sdo::make_turn(Response::download_segment, toggle_);
  toggle_ = !toggle_;
  return turn;
}

Message SdoServer::initiate_upload() noexcept {
  reset();
  const AbortCode code = objects_.read(address_, data_, size_);
  if (code != AbortCode::none) return abort(code);
  if (size_ > 0 && size_ <= sdo::expedited_capacity)
    return sdo::make_expedited(Response::initiate_upload, address_, std::span(data_).first(size_));
  position_ = 0;
  toggle_ = false;
  transfer_ = Transfer::upload;
  return sdo::make_announcement(Response::initiate_upload, address_, static_cast<std::uint32_t>(size_));
}

Message SdoServer::upload_segment(const Message& request) noexcept {
  if (transfer_ != Transfer::upload) return abort(AbortCode::unknown_command);
  if (sdo::toggle_of(request) != toggle_) return abort(AbortCode::toggle_not_alternated);
  const std::size_t count = std::min(sdo::segment_capacity, size_ - position_);
  const auto bytes = std::span<const std::uint8_t>(data_).subspan(position_, count);
  position_ += count;
  const bool last = position_ == size_;
  const Message segment = sdo::make_segment(Response::upload_segment, toggle_, last, bytes);
  toggle_ = !toggle_;
  if (last) reset();
  return segment;
}

Message SdoServer::abort(AbortCode code) noexcept {
  reset();
  return sdo::make_abort(address_, code);
}

}  // namespace godobject
