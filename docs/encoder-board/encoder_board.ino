// Two quadrature encoders to the host at 1 kHz. Frame: docs/trackers.md, "Encoder boards". For any Arduino with two
// interrupt pins per encoder; a Teensy, ESP32 or Due keeps up with 100 000 edges per second.
const int kEncoders = 2, kPinA[kEncoders] = {2, 4}, kPinB[kEncoders] = {3, 5};
const uint32_t kPeriod_us = 1000, kBaud = 921600;

volatile int32_t counts[kEncoders];
volatile uint8_t last[kEncoders];
volatile uint16_t status = 0x0001;  // not referenced: counts from where it was switched on
uint8_t payload[10 + 4 * kEncoders], wire[sizeof(payload) + 2];
size_t size;

uint8_t levels(int i) { return digitalRead(kPinA[i]) << 1 | digitalRead(kPinB[i]); }
void edge(int i) {
  // Change of (A, B) in Gray code: 0 none, +-1 a step, 2 both at once: an edge was missed.
  static const int8_t step[16] = {0, 1, -1, 2, -1, 0, 2, 1, 1, 2, 0, -1, 2, -1, 1, 0};
  const uint8_t now = levels(i);
  const int8_t change = step[last[i] << 2 | now];
  if (change == 2) status = status | 0x0002; else counts[i] = counts[i] + change;
  last[i] = now;
}
void (*const handlers[kEncoders])() = {[] { edge(0); }, [] { edge(1); }};

void put(uint32_t value, int bytes) { while (bytes-- > 0) { payload[size++] = value; value >>= 8; } }
uint16_t crc16() {  // CRC-16/CCITT-FALSE
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) {
    crc ^= uint16_t(payload[i]) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1;
  }
  return crc;
}
void send() {  // COBS; shorter than 254 bytes, so without full blocks
  size_t code = 0, n = 1;
  for (size_t i = 0; i < size; ++i) {
    if (payload[i] != 0) { wire[n++] = payload[i]; continue; }
    wire[code] = n - code, code = n++;
  }
  wire[code] = n - code, wire[n++] = 0;
  Serial.write(wire, n);
}

void setup() {
  Serial.begin(kBaud);
  for (int i = 0; i < kEncoders; ++i) {
    for (int pin : {kPinA[i], kPinB[i]})
      pinMode(pin, INPUT_PULLUP), attachInterrupt(digitalPinToInterrupt(pin), handlers[i], CHANGE);
    last[i] = levels(i);
  }
}
void loop() {
  static uint32_t next = micros(), sequence = 0;
  if (int32_t(micros() - next) < 0) return;
  next += kPeriod_us;
  size = 0, put(0x01, 1), put(sequence++, 1);
  noInterrupts(), put(micros(), 4);
  for (int i = 0; i < kEncoders; ++i) put(counts[i], 4);
  put(status, 2);
  status = status & ~0x0002, interrupts();
  put(crc16(), 2), send();
}
