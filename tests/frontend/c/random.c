/* Random programs: loops, branches and memory, without signed overflow. */

int f0(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (unsigned i1=1; i1<9; i1+=2) {
    if (((int)((unsigned)(m)*(unsigned)(8))) == ((int)(((int)q)%8))) {
      s = b[((((s) == (-7))?(m):(t)))&15];
      if ((((int)q) == ((int)i1)) || (x[((int)i1+2)&15] <= x[3])) break;
    }
    t = a[((int)i1)&15];
  }
  if (((int)((unsigned)(t)+(unsigned)((int)q))) == ((int)((unsigned)(t)^(unsigned)(m)))) {
    b[(m)&15] = (int)((unsigned)(b[7])<<4);
    a[3] = (int)((unsigned)(((-9)>>27))^(unsigned)((int)((unsigned)((int)q)*(unsigned)(t))));
    b[3] = ((((1) > ((int)q)) && (x[9] > x[3]))?(t):(b[9]));
  } else {
    if (x[14] == x[3]) {
      for (int *p2=b; p2<b+n; p2++) {
        for (int i3=7; i3>0; i3-=1) {
          s = a[(n)&15];
          if (x[(i3)&15] < 0.5f) {
            for (unsigned i4=0; i4<(unsigned)n; i4+=1) {
              a[10] = n;
            }
            x[(*p2*3)&15] = x[(i3)&15] - 1.25f;
          } else {
            a[(*p2+-2)&15] = t;
            u[((int)u[(i3+1)&15])&15] = (unsigned)((int)((unsigned)((int)((unsigned)(*p2)+(unsigned)(t)))^(unsigned)(i3)));
            if ((x[(i3+1)&15] <= 0.5f) && ((unsigned)(*p2) > (unsigned)(t))) return (int)((unsigned)((int)((unsigned)((int)q)<<12))<<7);
          }
          t = a[((int)((unsigned)(m)+(unsigned)(t)))&15];
        }
      }
      b[13] = (int)((unsigned)(n)-(unsigned)(n));
    }
  }
  b[15] = s;
  return s ^ t ^ (int)q;
}

int f1(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int *p1=a; p1<a+n; p1++) {
    t = (((int)q)>>24);
    s = (int)((unsigned)((int)((unsigned)(*p1)-(unsigned)(-9)))*(unsigned)((int)((unsigned)(4)&(unsigned)((int)q))));
  }
  t = (int)((unsigned)(a[9])*(unsigned)((int)((unsigned)((int)q)^(unsigned)(m))));
  s = b[((int)((unsigned)(m)+(unsigned)(2)))&15];
  for (int i2=0; i2!=n; i2++) {
    int i3=2; do {
      if (((int)((unsigned)(i3)&(unsigned)(i3))) >= ((int)((unsigned)(s)|(unsigned)(i2)))) break;
      switch ((a[(i3*3)&15])&3) {
      case 0: t ^= (m)&1023; break;
      case 1: t ^= (i2)&1023; 
      case 2: s += (s)&1023; 
      case 3: s += (s)&1023; break;
      default: s ^= 5; }
    } while (++i3 < n-1);
    a[(i2)&15] = a[9];
    b[6] = (int)((unsigned)(b[13])+(unsigned)((int)((unsigned)(i2)>>19)));
  }
  return s ^ t ^ (int)q;
}

int f2(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1<n; i1+=1) {
    a[(i1*3)&15] = b[(i1+2)&15];
    for (int i2=0; i2<i1; i2+=2) {
      a[(i1+-1)&15] = m;
      for (long i3=m-2; i3<=(n&7); i3+=2) {
        s ^= ((n)>>28);
        b[((int)((unsigned)((int)q)-(unsigned)(2)))&15] = b[(i1*3)&15];
        s ^= (int)((unsigned)((int)i3)>>19);
      }
      for (int i4=(n&7); i4>=m-2; i4-=3) {
        b[2] = (int)((unsigned)(a[3])+(unsigned)((int)u[1]));
        if (((n) > (i1)) && ((unsigned)(i1) < (unsigned)(i4))) {
          t = (int)u[1];
          if ((unsigned)(i1) <= (unsigned)((int)((unsigned)(i1)&(unsigned)(i4)))) {
            if ((i1) != (i1)) {
              b[1] = m;
            } else {
              if (x[(i1)&15] <= 1.0f) break;
              if (((int)((unsigned)(m)&(unsigned)(s))) >= ((int)((-6)%4))) {
                s = (int)((unsigned)((int)((unsigned)(t)*(unsigned)(s)))*(unsigned)(((6)>>13)));
              }
              if ((x[(i4)&15] == 1.0f) && ((i1) > (i4))) {
                b[((int)((unsigned)(s)+(unsigned)(i4)))&15] = ((((unsigned)(m) > (unsigned)(m)) && (x[(i4*3)&15] < x[3]))?((int)((unsigned)(i1)|(unsigned)(m))):((int)((unsigned)(i1)>>18)));
              } else {
                if (((int)u[(i1*3)&15]) >= (i2)) {
                  s = (int)((unsigned)((int)((unsigned)(i1)^(unsigned)(m)))>>11);
                  x[(i2+1)&15] = x[13] * (float)(t&255);
                  s ^= (int)((unsigned)(7)+(unsigned)(s));
                }
                b[(a[(i4)&15])&15] = ((4)>>16);
                s = (int)((unsigned)(((((int)q) != (9))?(1):(7)))-(unsigned)(n));
              }
            }
            b[(i4)&15] = m;
          }
        }
        b[(i1)&15] = (int)((unsigned)((int)((unsigned)(0)-(unsigned)((int)q)))&(unsigned)((int)((unsigned)(i4)*(unsigned)(m))));
      }
    }
    s = (int)((unsigned)(a[2])-(unsigned)(a[(i1+-1)&15]));
  }
  t = (int)((unsigned)((int)((n)%4))-(unsigned)(m));
  b[((((int)q)>>24))&15] = (((int)((unsigned)(7)*(unsigned)((int)q)))>>25);
  return s ^ t ^ (int)q;
}

int f3(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=m; i1>=0; i1-=3) {
    b[(i1*3)&15] = (int)((unsigned)((int)((unsigned)(-2)^(unsigned)(n)))|(unsigned)((int)((unsigned)((int)q)^(unsigned)(i1))));
    switch (((int)((unsigned)(3)<<27))&7) {
    case 0: t += (s)&1023; break;
    case 1: t += ((int)q)&1023; 
    case 2: t ^= (m)&1023; break;
    case 3: t += ((int)q)&1023; break;
    default: s ^= 5; }
    if ((unsigned)((int)((unsigned)(-3)|(unsigned)(i1))) > (unsigned)((int)q)) {
      for (int *p2=a; p2<a+n; p2++) {
        switch (((int)((unsigned)(-8)>>21))&7) {
        case 0: s += (t)&1023; 
        case 1: s += (n)&1023; break;
        case 2: s ^= (-5)&1023; break;
        case 3: t ^= (t)&1023; 
        default: t ^= 5; }
        s = (((b[(i1*3)&15]) > (i1))?((int)q):(b[((int)((unsigned)(m)+(unsigned)(n)))&15]));
      }
      a[(i1+2)&15] = b[(i1*3)&15];
      if ((unsigned)(b[(i1+3)&15]) <= (unsigned)((int)((unsigned)(1)+(unsigned)((int)q)))) break;
    } else {
      if (((int)((unsigned)(m)-(unsigned)((int)q))) == (i1)) {
        b[(i1*3)&15] = ((b[9])>>30);
        for (int i3=m-2; i3<=12; i3+=1) {
          for (int i4=(n&7); i4>=0; i4-=3) {
            s ^= ((x[(i1*3)&15] <= 0.5f)?(-9):((int)q));
          }
          u[13] += (unsigned)((((((i3)>>7)) == ((int)((unsigned)(n)>>8)))?((int)((unsigned)(9)<<3)):(((7)>>3))));
        }
        s = (int)((unsigned)(((s)>>30))<<2);
      }
      b[(i1+-2)&15] = b[(i1)&15];
      s ^= (int)u[(i1*3)&15];
    }
  }
  x[(5)&15] = x[1] + x[2];
  q = q * q + (unsigned)((int)((unsigned)(s)&(unsigned)(2)));
  return s ^ t ^ (int)q;
}

int f4(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (long i1=1; i1<m; i1+=2) {
    b[((int)i1)&15] = (int)((unsigned)(a[(a[8])&15])*(unsigned)((int)((unsigned)(n)|(unsigned)((int)q))));
  }
  u[((int)((unsigned)(m)<<18))&15] += (unsigned)(n);
  for (int i2=0; i2<=n; i2+=3) {
    t = s;
    s = (int)((unsigned)(b[(i2*3)&15])&(unsigned)(s));
    for (unsigned i3=0; i3<(unsigned)n; i3+=3) {
      u[((int)i3)&15] += (unsigned)((int)((unsigned)(m)*(unsigned)((((n) == (n))?(i2):(m)))));
    }
  }
  return s ^ t ^ (int)q;
}

int f5(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  int i1=1; do {
    switch ((a[3])&3) {
    case 0: t += (t)&1023; break;
    case 1: s ^= ((int)q)&1023; break;
    case 2: s += ((int)q)&1023; break;
    default: t ^= 5; }
    u[(i1*3)&15] = (unsigned)((((b[(i1)&15]) > (a[(i1+-2)&15]))?(b[(i1+-1)&15]):((int)((unsigned)(-9)-(unsigned)(s)))));
  } while (++i1 < 12);
  q = q * 5u + (unsigned)(a[((int)((unsigned)(m)-(unsigned)(2)))&15]);
  switch ((n)&3) {
  case 0: s += (t)&1023; break;
  case 1: t += (n)&1023; break;
  case 2: s += (m)&1023; break;
  default: s ^= 5; }
  for (int i2=n; i2>m-2; i2-=1) {
    t = (int)q;
    s = t;
  }
  return s ^ t ^ (int)q;
}

int f6(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1<12; i1+=1) {
    if ((((i1)>>31)) <= ((int)((unsigned)(8)&(unsigned)(m)))) {
      for (int *p2=b; p2!=b+n; p2++) {
        for (int i3=1; i3<=i1; i3+=1) {
          s ^= *p2;
          s ^= (int)(((int)q)%8);
          if ((((n)>>15)) == ((int)u[(i1*3)&15])) {
            q = q * 3u + (unsigned)((int)((unsigned)(m)*(unsigned)(*p2)));
            s ^= (int)((unsigned)(i1)>>1);
            if (((int)((unsigned)((int)q)|(unsigned)(-5))) < (t)) {
              a[14] = t;
              b[(i3+1)&15] = (int)((b[((int)((unsigned)(6)*(unsigned)(3)))&15])%8);
            }
          } else {
            b[8] = ((((int)u[(t)&15]) > ((((i1) < (t))?(6):(s))))?((int)((unsigned)(i1)-(unsigned)(-1))):((int)((unsigned)(*p2)+(unsigned)(5))));
            switch (((int)u[(i3)&15])&7) {
            case 0: t ^= ((int)q)&1023; break;
            case 1: t ^= (4)&1023; break;
            case 2: s += ((int)q)&1023; 
            default: s ^= 5; }
            if ((unsigned)(m) > (unsigned)((int)((unsigned)(m)>>8))) continue;
          }
        }
        if ((s) <= ((int)((unsigned)(-5)-(unsigned)(i1)))) return (int)u[(*p2*3)&15];
      }
      if (((int)((unsigned)(m)-(unsigned)((int)q))) == ((int)((unsigned)(-2)^(unsigned)(i1)))) {
        a[(i1)&15] = n;
        if (((m) < ((int)q)) || (x[(i1+-2)&15] < x[3])) return (int)((unsigned)(s)+(unsigned)(((((int)q) != (4))?(n):((int)q))));
        if (x[(i1)&15] < 0.5f) {
          if (x[((int)((4)%2))&15] <= 1.0f) {
            x[(i1)&15] = x[(a[(i1*3)&15])&15] - (float)(t&255);
          }
          if ((a[(i1+-1)&15]) < (((m)>>10))) {
            b[(i1*3)&15] = (int)((unsigned)((int)q)>>0);
          } else {
            u[(i1)&15] += (unsigned)(m);
            if (x[(a[((int)((unsigned)(i1)+(unsigned)((int)q)))&15])&15] < 0.5f) {
              a[3] = a[7];
            }
          }
        }
      }
      a[(i1+2)&15] = (int)((unsigned)((int)((unsigned)(s)+(unsigned)(n)))*(unsigned)((((-1) < (s))?(t):(i1))));
    }
  }
  t = (((((n) < ((int)q))?(s):((int)q)))>>12);
  for (unsigned i4=1; i4<9; i4+=1) {
    s ^= (int)((unsigned)(-2)+(unsigned)(m));
    s ^= (int)((unsigned)((int)i4)|(unsigned)(m));
    u[((int)i4*3)&15] += (unsigned)((int)((unsigned)(a[((int)i4*3)&15])*(unsigned)(n)));
  }
  return s ^ t ^ (int)q;
}

int f7(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1<=n-1; i1+=1) {
    x[(i1)&15] = x[(i1)&15] - (float)(t&255);
  }
  a[((int)((unsigned)(s)&(unsigned)(n)))&15] = -6;
  u[5] += (unsigned)(-7);
  for (unsigned i2=1; i2<=9; i2+=2) {
    x[((int)i2)&15] = x[((int)i2+2)&15] * (float)(t&255);
    u[((int)((unsigned)(n)-(unsigned)((int)q)))&15] += (unsigned)((int)((unsigned)((int)((unsigned)((int)i2)&(unsigned)(s)))|(unsigned)((int)((unsigned)((int)i2)*(unsigned)(s)))));
  }
  return s ^ t ^ (int)q;
}

int f8(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  int i1=1; while (i1<m && (-2) <= ((int)u[((int)((unsigned)(s)&(unsigned)((int)q)))&15])) { i1++;
    t = (int)((unsigned)(a[(i1*3)&15])^(unsigned)(-2));
    a[(i1)&15] = (int)((unsigned)((int)((unsigned)(n)-(unsigned)(i1)))+(unsigned)((int)((unsigned)(m)&(unsigned)(2))));
    for (int i2=m-2; i2<=12; i2+=1) {
      s = (((int)((unsigned)(i2)<<22))>>15);
      for (int i3=1; i3<n-1; i3+=2) {
        u[13] ^= (unsigned)((int)((unsigned)(i3)<<7));
        b[(i1+2)&15] = (int)((9)%4);
      }
    }
  }
  s = a[3];
  for (int i4=0; i4<n; i4+=1) {
    if ((b[(i4)&15]) == (t)) {
      x[(i4)&15] = x[(((s)>>6))&15] - x[2];
    }
    s = (int)((unsigned)((int)((unsigned)(t)*(unsigned)(s)))&(unsigned)(a[0]));
    u[(i4+-2)&15] ^= (unsigned)(a[(b[(i4+3)&15])&15]);
  }
  return s ^ t ^ (int)q;
}

int f9(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=m-2; i1<=7; i1+=1) {
    x[(i1*3)&15] = x[1] + x[2];
  }
  s = ((a[((int)((unsigned)(n)^(unsigned)(n)))&15])>>2);
  a[((int)((unsigned)(s)>>15))&15] = (int)((unsigned)(((x[6] < x[3])?(m):((int)q)))+(unsigned)(((t)>>2)));
  for (int i2=n; i2>=0; i2-=1) {
    for (unsigned i3=1; i3<(unsigned)n; i3+=1) {
      for (long i4=1; i4<=12; i4+=1) {
        b[(i2)&15] = (int)u[(i2*3)&15];
        u[(i2+-2)&15] ^= (unsigned)((((int)((unsigned)(t)^(unsigned)(t)))>>25));
        t = i2;
      }
    }
  }
  return s ^ t ^ (int)q;
}

int f10(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (unsigned i1=0; i1<9; i1+=1) {
    if (x[((int)i1)&15] > 1.0f) {
      for (int i2=1; i2<12; i2+=1) {
        if (((int)q) == (a[((int)i1*3)&15])) {
          switch ((b[((int)i1*3)&15])&7) {
          case 0: s += (s)&1023; break;
          case 1: t ^= (t)&1023; break;
          case 2: t ^= (t)&1023; break;
          case 3: t += (m)&1023; break;
          default: t ^= 5; }
          t = (int)i1;
        }
      }
      b[((int)i1+-1)&15] = ((a[((int)i1+0)&15])>>15);
    } else {
      s = b[7];
      t = (int)((unsigned)((int)((unsigned)((int)q)|(unsigned)(n)))&(unsigned)((int)((unsigned)(s)+(unsigned)(t))));
    }
    t = (((int)(((int)q)%8))>>29);
  }
  s = (int)((unsigned)((int)((unsigned)(9)^(unsigned)(s)))*(unsigned)(((t)>>18)));
  for (int *p3=a; p3<a+n; p3++) {
    x[(*p3)&15] = x[(*p3)&15] + 1.25f;
  }
  return s ^ t ^ (int)q;
}

int f11(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int *p1=a; p1!=a+n; p1++) {
    s = t;
    a[(*p1*3)&15] = (int)((unsigned)((int)q)^(unsigned)((int)((unsigned)(m)+(unsigned)(*p1))));
    s = (int)((unsigned)(a[((int)((unsigned)(-7)&(unsigned)(m)))&15])^(unsigned)((int)q));
  }
  a[12] = a[((int)u[6])&15];
  if ((x[1] == x[3]) || (x[6] <= 1.0f)) return a[4];
  for (long i2=1; i2<=12; i2+=1) {
    for (int i3=2; i3<m; i3+=1) {
      a[((int)i2+3)&15] = (int)((unsigned)((int)((unsigned)(s)&(unsigned)(i3)))>>25);
      b[((int)i2)&15] = t;
      u[((int)((unsigned)(i3)+(unsigned)(n)))&15] ^= (unsigned)((int)((unsigned)((int)q)-(unsigned)(((((int)i2) == ((int)q))?(s):((int)q)))));
    }
    b[((int)i2+-2)&15] = (int)((unsigned)((int)q)^(unsigned)((((unsigned)(s) > (unsigned)((int)q))?(m):(m))));
  }
  return s ^ t ^ (int)q;
}

int f12(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1!=n; i1++) {
    b[(i1*3)&15] = a[4];
    for (long i2=m-2; i2<(n&7); i2+=2) {
      s = (int)((unsigned)((int)((unsigned)(i1)^(unsigned)(-7)))|(unsigned)((int)((unsigned)(6)^(unsigned)((int)i2))));
      for (int i3=1; i3<=(n&7); i3+=2) {
        a[((int)i2*3)&15] = (((int)((unsigned)(s)+(unsigned)(m)))>>2);
        x[(((i3)>>2))&15] = x[((int)i2*3)&15] - 0.5f;
      }
      t = b[((int)i2)&15];
    }
  }
  t = -2;
  b[10] = a[((int)q)&15];
  return s ^ t ^ (int)q;
}

int f13(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1!=n; i1++) {
    a[5] = (int)((unsigned)((int)u[(((((int)q) >= ((int)q))?((int)q):(m)))&15])+(unsigned)((int)((unsigned)(i1)&(unsigned)(-1))));
    s = (int)u[(a[(i1+0)&15])&15];
    if ((unsigned)(m) < (unsigned)((int)((unsigned)(s)-(unsigned)(n)))) {
      if ((n) != ((int)((unsigned)(-4)<<26))) break;
    }
  }
  int i2=0; do {
    if (((int)((unsigned)((int)q)-(unsigned)(9))) == (9)) {
      x[(i2*3)&15] = x[(i2)&15] * 0.5f;
      for (int i3=0; i3!=n; i3++) {
        for (int i4=2; i4<=n; i4+=3) {
          b[(i2+-2)&15] = b[(i4+2)&15];
          a[(i2*3)&15] = (int)((unsigned)((int)((unsigned)(i4)*(unsigned)(n)))-(unsigned)(((i3)>>22)));
          t = a[(i2)&15];
        }
      }
      if ((unsigned)((int)u[12]) > (unsigned)((int)((unsigned)(m)<<24))) {
        a[(i2*3)&15] = (int)((unsigned)(((x[(i2+-2)&15] <= x[3])?(t):(s)))>>30);
        s ^= (int)q;
      }
    } else {
      if (((int)((unsigned)(m)&(unsigned)(s))) < ((int)((unsigned)(m)|(unsigned)(m)))) {
        b[(i2*3)&15] = 7;
        a[13] = n;
      }
    }
    t = n;
    u[(i2+0)&15] = (unsigned)(((x[11] < x[3])?((int)((t)%2)):(t)));
  } while (++i2 < n-1);
  u[15] ^= (unsigned)((int)q);
  return s ^ t ^ (int)q;
}

int f14(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  int i1=m-2; do {
    if (x[(i1+0)&15] == 0.5f) break;
    b[(i1*3)&15] = (int)((unsigned)(t)-(unsigned)(s));
  } while (++i1 < n);
  if ((x[12] == x[3]) && (x[(((s)>>5))&15] > 1.0f)) {
    b[((int)u[((int)((unsigned)(m)&(unsigned)(n)))&15])&15] = b[((int)((unsigned)((int)q)*(unsigned)(s)))&15];
  }
  x[11] = x[9] * 1.25f;
  for (int i2=0; i2<=m; i2+=1) {
    a[(i2+0)&15] = b[(i2*3)&15];
    b[(i2+-2)&15] = ((-8)>>9);
  }
  return s ^ t ^ (int)q;
}

int f15(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=m; i1>0; i1-=1) {
    for (int *p2=a; p2<a+n; p2++) {
      if (x[(i1+-1)&15] > 1.0f) continue;
      for (long i3=2; i3<12; i3+=2) {
        t = (int)u[((int)i3+3)&15];
      }
    }
  }
  s = (int)((unsigned)(t)+(unsigned)((int)((unsigned)(n)^(unsigned)(s))));
  for (unsigned i4=1; i4<(unsigned)n; i4+=1) {
    s ^= a[((int)i4+3)&15];
    x[((int)i4+-2)&15] = x[((int)i4+3)&15] * (float)(t&255);
    b[(a[((int)i4)&15])&15] = (int)((unsigned)(n)&(unsigned)((int)((unsigned)(t)<<28)));
  }
  return s ^ t ^ (int)q;
}

int f16(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (long i1=2; i1<n-1; i1+=1) {
    t = a[((int)i1*3)&15];
  }
  b[7] = a[0];
  if ((s) >= ((int)((unsigned)(m)+(unsigned)((int)q)))) {
    for (int i2=n-1; i2>=0; i2-=3) {
      if (((int)((unsigned)(-6)+(unsigned)(t))) < (a[3])) {
        a[((int)((unsigned)(n)*(unsigned)(n)))&15] = -9;
        b[(s)&15] = (int)((unsigned)(t)*(unsigned)((int)((unsigned)(n)<<27)));
        t = (int)q;
      } else {
        b[(b[2])&15] = (int)((unsigned)((int)((unsigned)(-6)^(unsigned)(n)))&(unsigned)(6));
        if (((int)((unsigned)(i2)+(unsigned)(t))) >= (a[7])) return 8;
      }
      int i3=m-2; do {
        a[(i3)&15] = (int)((unsigned)((int)((unsigned)(t)-(unsigned)(t)))^(unsigned)(t));
        if ((b[(i2)&15]) < ((int)((unsigned)(i3)-(unsigned)(t)))) break;
        for (long i4=1; i4<7; i4+=3) {
          if ((unsigned)(t) < (unsigned)((((i3) >= (n))?(n):(m)))) return b[(i2)&15];
          s ^= (int)((unsigned)(i2)^(unsigned)(i2));
        }
      } while (++i3 < m);
      if (((int)((unsigned)(n)*(unsigned)(s))) < ((int)((unsigned)(s)>>8))) continue;
    }
  }
  return s ^ t ^ (int)q;
}

int f17(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int *p1=a; p1<a+n; p1++) {
    for (int *p2=b; p2<b+n; p2++) {
      for (int *p3=a; p3<a+n; p3++) {
        a[(*p1+2)&15] = (int)((unsigned)((int)q)|(unsigned)((int)((s)%8)));
        x[((int)((unsigned)(t)+(unsigned)((int)q)))&15] = x[(*p1)&15] - x[2];
        b[(*p3)&15] = s;
      }
    }
  }
  t = (int)((unsigned)((int)((unsigned)(s)*(unsigned)((int)q)))+(unsigned)((int)q));
  for (int i4=2; i4<=12; i4+=1) {
    s ^= i4;
  }
  return s ^ t ^ (int)q;
}

int f18(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1!=n; i1++) {
    for (int i2=2; i2<(n&7); i2+=2) {
      a[(i1)&15] = b[(i1+3)&15];
    }
  }
  b[10] = (int)((unsigned)(m)&(unsigned)((int)((unsigned)(-1)^(unsigned)(m))));
  a[(-7)&15] = b[(((x[((int)((unsigned)(t)&(unsigned)((int)q)))&15] <= 0.5f)?(t):(s)))&15];
  for (int i3=m; i3>=0; i3-=1) {
    switch ((((n)>>30))&7) {
    case 0: s += (i3)&1023; 
    case 1: t ^= (i3)&1023; 
    default: s ^= 5; }
  }
  return s ^ t ^ (int)q;
}

int f19(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  int i1=0; do {
    b[9] = (((int)((unsigned)(s)>>12))>>7);
    q = q * 5u + (unsigned)((int)((unsigned)(n)>>1));
    b[((int)u[5])&15] = -5;
  } while (++i1 < (n&7));
  t = m;
  if (((int)((unsigned)(4)<<11)) < (a[(t)&15])) {
    t = (int)((unsigned)((int)u[((int)q)&15])&(unsigned)(m));
    s = s;
  } else {
    t = (int)((unsigned)(b[2])<<22);
  }
  for (int i2=0; i2<n-1; i2+=1) {
    if (x[(i2)&15] > x[3]) {
      q = q * q + (unsigned)((int)((unsigned)(i2)*(unsigned)(n)));
      for (long i3=0; i3<=n; i3+=1) {
        for (long i4=i2+1; i4<n-1; i4+=1) {
          b[((int)((unsigned)(s)^(unsigned)(n)))&15] = b[((int)i3)&15];
          s ^= a[((int)i4*3)&15];
        }
        a[13] = (int)((unsigned)((int)((unsigned)((int)i3)<<18))|(unsigned)(i2));
        b[((int)i3)&15] = a[((int)i3)&15];
      }
    }
    b[(i2)&15] = (int)((unsigned)((int)((unsigned)(s)&(unsigned)(m)))&(unsigned)(b[(i2+1)&15]));
  }
  return s ^ t ^ (int)q;
}

int f20(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1<=(n&7); i1+=1) {
    b[(m)&15] = (int)u[(i1+0)&15];
  }
  b[((int)((unsigned)(t)+(unsigned)(n)))&15] = s;
  a[((int)((unsigned)(n)+(unsigned)(1)))&15] = (int)(((int)((t)%2))%4);
  for (int i2=0; i2!=n; i2++) {
    a[(i2)&15] = (int)((unsigned)(s)<<20);
    if (((int)((unsigned)(s)^(unsigned)(i2))) < (s)) {
      a[9] = (int)((unsigned)((int)((unsigned)(n)>>6))>>13);
      a[(i2+2)&15] = (int)((unsigned)((int)((unsigned)(t)&(unsigned)(n)))>>6);
    }
  }
  return s ^ t ^ (int)q;
}

int f21(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1!=n; i1++) {
    for (unsigned i2=0; i2<(unsigned)n; i2+=1) {
      s = ((a[13])>>21);
      s = (int)q;
      int i3=0; do {
        b[((int)i2+-1)&15] = (int)(((int)((unsigned)(2)>>24))%4);
        s ^= a[((int)((unsigned)((int)q)&(unsigned)((int)i2)))&15];
        q = q * q + (unsigned)(n);
      } while (++i3 < m);
    }
  }
  int i4=1; do {
    a[11] = (int)u[0];
  } while (++i4 < n-1);
  a[(((s)>>16))&15] = t;
  return s ^ t ^ (int)q;
}

int f22(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (long i1=0; i1<=m; i1+=1) {
    if ((((s)>>20)) == (8)) break;
  }
  for (int i2=(n&7); i2>=0; i2-=3) {
    a[(i2+3)&15] = (int)((unsigned)(i2)*(unsigned)((int)((t)%4)));
    for (int i3=i2+1; i3<=(n&7); i3+=1) {
      t = (int)((unsigned)((int)((unsigned)(n)>>23))|(unsigned)(a[(i3*3)&15]));
    }
  }
  s = (((unsigned)((int)u[((int)((unsigned)(t)&(unsigned)(m)))&15]) < (unsigned)(b[14]))?((int)((unsigned)(s)+(unsigned)(m))):(m));
  return s ^ t ^ (int)q;
}

int f23(int *restrict a, int *restrict b, unsigned *restrict u, float *restrict x, int n, int m) {
  int s = 1, t = n; unsigned q = 7;
  for (int i1=0; i1<n-1; i1+=2) {
    x[8] = x[15] + 1.25f;
    if (((((unsigned)(m) > (unsigned)(m))?(t):((int)q))) >= ((int)((unsigned)(m)-(unsigned)(t)))) {
      a[(i1+2)&15] = (int)((unsigned)(b[9])<<7);
      if ((a[3]) > ((int)((unsigned)(i1)-(unsigned)(m)))) break;
      if (((int)((unsigned)(t)-(unsigned)((int)q))) > ((int)((unsigned)(s)&(unsigned)(m)))) {
        t = (((int)((unsigned)(s)|(unsigned)(i1)))>>27);
        a[(i1*3)&15] = (((((x[(i1*3)&15] == 1.0f)?(t):(s))) >= ((int)((unsigned)(8)&(unsigned)(m))))?(a[(i1+1)&15]):(((i1)>>20)));
      }
    }
    b[(i1*3)&15] = (int)((unsigned)((int)((unsigned)(n)>>13))|(unsigned)((int)((unsigned)(m)>>23)));
  }
  b[((int)((unsigned)(n)&(unsigned)(t)))&15] = n;
  a[(m)&15] = a[5];
  for (int i2=n; i2>=0; i2-=1) {
    for (int i3=n; i3>=0; i3-=1) {
      x[(i2+-1)&15] = x[7] * (float)(t&255);
    }
    for (int i4=0; i4<=n-1; i4+=1) {
      b[(i2+-2)&15] = (int)((unsigned)((int)((unsigned)(m)<<15))&(unsigned)(((x[(i2+1)&15] == 1.0f)?(i2):(-3))));
      s ^= (int)((unsigned)(n)+(unsigned)(-8));
      x[((int)((unsigned)((int)q)-(unsigned)(t)))&15] = x[(i2+3)&15] + 0.5f;
    }
    if (((int)((unsigned)(i2)-(unsigned)(n))) == ((((t) != (t))?(-5):(i2)))) return s;
  }
  return s ^ t ^ (int)q;
}
