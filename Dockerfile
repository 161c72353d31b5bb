# A static binary in an image that holds nothing else.
#
#   docker build -t takt .
#   docker run --rm -p 127.0.0.1:8080:8080 -v takt-data:/data takt

FROM rust:1.90-slim-bookworm AS build
# musl-gcc compiles the bundled SQLite.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends musl-tools \
    && rm -rf /var/lib/apt/lists/* \
    && rustup target add x86_64-unknown-linux-musl
WORKDIR /takt
# Dependencies first, against an empty program: they are compiled anew only
# when the manifests change. The manifest names the benches, so they must exist.
COPY Cargo.toml Cargo.lock ./
COPY benches benches
RUN mkdir -p src \
    && echo 'fn main() {}' | tee src/main.rs build.rs > /dev/null \
    && touch src/lib.rs \
    && CC_x86_64_unknown_linux_musl=musl-gcc \
       cargo build --release --locked --target x86_64-unknown-linux-musl --bin takt \
    && rm -rf src build.rs
COPY . .
# Cargo goes by times: without this it would keep the empty program.
RUN touch src/main.rs src/lib.rs build.rs \
    && CC_x86_64_unknown_linux_musl=musl-gcc \
       cargo build --release --locked --target x86_64-unknown-linux-musl --bin takt \
    && strip target/x86_64-unknown-linux-musl/release/takt \
    && mkdir -p /image/data /image/tmp \
    && chmod 1777 /image/tmp \
    && cp target/x86_64-unknown-linux-musl/release/takt /image/takt

FROM scratch
LABEL org.opencontainers.image.title="Takt" \
      org.opencontainers.image.description="Plans time-optimal, certified robot trajectories as a service" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build --chown=65532:65532 /image /
USER 65532:65532
# Inside a container all addresses are the container's own; which of them the
# world reaches is decided by publishing the port.
ENV TAKT_LISTEN=0.0.0.0:8080 \
    TAKT_DATA_DIR=/data
EXPOSE 8080
VOLUME /data
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=3s --start-period=5s \
    CMD ["/takt", "health", "--server", "http://127.0.0.1:8080"]
ENTRYPOINT ["/takt"]
CMD ["serve"]
