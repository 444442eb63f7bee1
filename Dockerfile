FROM python:3.11-slim AS build
RUN python -m venv /opt/abi
ENV PATH=/opt/abi/bin:$PATH PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
WORKDIR /src
COPY requirements.lock .
RUN pip install --require-hashes -r requirements.lock
COPY . .
# Kernels are compiled for any processor of this architecture, so that they fit where the image runs.
RUN ABI_READY_KERNELS=1 pip install --no-deps --no-build-isolation .

FROM python:3.11-slim
COPY --from=build /opt/abi /opt/abi
ENV PATH=/opt/abi/bin:$PATH PYTHONUNBUFFERED=1
RUN useradd --create-home --uid 1000 abi
USER abi
WORKDIR /home/abi
# A volume that is mounted here belongs to this user, too.
RUN mkdir uploads
EXPOSE 8080
STOPSIGNAL SIGTERM
# 200 once plans can be made; needs no token.
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s \
    CMD ["python", "-c", "import urllib.request as r; r.urlopen('http://127.0.0.1:8080/healthz', timeout=4)"]
CMD ["abi", "serve", "--host", "0.0.0.0", "--port", "8080", "--no-open"]
