# whipple as a service:  docker build -t whipple .
#
# The service asks for no login on the loopback, and refuses to listen anywhere else without one. Inside a
# container the loopback is the container's own, so the plain way to use it on one Linux machine is to share
# the host's network (this is what the default command is for):
#
#     docker run --network host --volume whipple:/data whipple
#
# Without a shared network the container has to listen on 0.0.0.0, and the service will then refuse to start
# until a trusted proxy has been declared to it. Put a reverse proxy that checks who is asking in front, publish
# the port to that proxy alone (never "-p 8000:8000" on an open machine), and say from where it asks:
#
#     docker run --env WHIPPLE_HOST=0.0.0.0 --env WHIPPLE_TRUSTED_PROXY='["172.18.0.2"]' \
#                --env WHIPPLE_ALLOWED_HOSTS='["whipple.example.org"]' --volume whipple:/data whipple
#
# With PostgreSQL, a scheduler and workers in containers of their own: compose.yaml.
#
# The base image is named by its tag, which moves with the patches of Python and Debian. To build twice from the same
# bytes, pin it by its digest, which the second line prints, and build with what it prints; a new digest is taken on
# purpose, with the date and the reason in the commit that changes it:
#
#     docker pull python:3.11-slim
#     docker image inspect --format '{{index .RepoDigests 0}}' python:3.11-slim       # python@sha256:...
#     docker build --build-arg BASE=python@sha256:... -t whipple .

ARG BASE=python:3.11-slim
# hadolint ignore=DL3006
FROM ${BASE} AS build
WORKDIR /source
RUN python -m venv /opt/whipple
ENV PATH=/opt/whipple/bin:$PATH
# The libraries first: they change less often than the source, and their layer is kept.
COPY pyproject.toml constraints.txt ./
RUN python -c "import tomllib; own = tomllib.load(open('pyproject.toml', 'rb'))['project']; print(*own['dependencies'], *(each for extra in ('postgres', 'cluster', 'zarr', 'video') for each in own['optional-dependencies'][extra]), sep='\n')" > libraries.txt \
 && pip install --no-cache-dir --constraint constraints.txt --requirement libraries.txt
COPY . .
RUN pip install --no-cache-dir --no-deps .

# hadolint ignore=DL3006
FROM ${BASE}
# tini: forwards signals and reaps children that died. Debian keeps no older version that could be pinned.
# hadolint ignore=DL3008
RUN apt-get update \
 && apt-get install --yes --no-install-recommends tini \
 && rm -rf /var/lib/apt/lists/*
RUN useradd --uid 10001 --create-home whipple \
 && install --directory --owner=whipple /data /var/cache/whipple
COPY --from=build /opt/whipple /opt/whipple
ENV PATH=/opt/whipple/bin:$PATH \
    WHIPPLE_DATA=/data \
    WHIPPLE_KERNEL_CACHE=/var/cache/whipple
USER 10001
WORKDIR /data
# Kernels are compiled for the x86-64 level of the machine that builds, and for v3, which nearly all have. On any other
# processor they are compiled once more, in the first run; mount a volume on /var/cache/whipple to keep those.
RUN whipple demo --warm \
 && if [ "$(uname -m)" = x86_64 ]; then NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES='' whipple demo --warm; fi
VOLUME /data
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s \
    CMD ["python", "-c", "import urllib.request as web; web.urlopen('http://127.0.0.1:8000/readyz', timeout=4)"]
ENTRYPOINT ["tini", "--"]
CMD ["whipple", "serve"]
